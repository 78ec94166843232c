"""A drive in memory: where it is and which way it points against the truth, outliers, and what is said before."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from station.locate.location import Location
from station.monitor.text_lines import json_line, reading_line
from station.monitor.view import MonitorView
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DrivenAlong, driven_along

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
TRACK = bends(60.0, still=16.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
JUMP = TimedFault("jump", 40.0, 1.0, 30.0)  # 30 m east for five fixes


def off(location: Location) -> float:
    """Return how far it is from the truth, level [m]; the first fix is where it stood."""
    gone = TRACK.position(location.t) - TRACK.position(0.0)
    return float(np.linalg.norm(np.array(location.enu)[:2] - gone[:2]))


def turned(location: Location) -> float:
    east, north, _ = TRACK.velocity(location.t)
    assert location.heading is not None
    return (location.heading - float(np.degrees(np.arctan2(east, north))) + 180) % 360 - 180


@pytest.fixture(scope="module")
def drive() -> DrivenAlong:
    return driven_along(46.0, TRACK, AUTOPILOT, TRUTH, faults=[JUMP])


def located(drive: DrivenAlong) -> list[MonitorView]:
    return [view for view in drive.lines if view.location is not None and view.location.is_located]


def test_it_says_what_is_missing_until_it_moves(drive: DrivenAlong) -> None:
    reported = [
        view.location.why for view in drive.lines if view.location is not None and not view.location.is_located
    ]
    assert reported[0] == "no fix yet"
    assert any("its noise is measured" in why for why in reported)
    assert "move it" in reported[-1]
    begun = located(drive)[0].location
    assert begun is not None
    assert 16.0 < begun.t < 30.0
    assert any("position and heading are known" in event.text for view in drive.lines for event in view.events)


def test_place_and_heading_are_the_truth_within_what_the_receiver_is_off(drive: DrivenAlong) -> None:
    settled = [view.location for view in located(drive) if view.location and view.location.t > 34.0]
    assert len(settled) > 100
    # of the two axes, its own error and the first fix's
    assert all(off(location) < 4 * np.sqrt(2) * max(location.enu_std[:2]) for location in settled)
    assert all(location.enu_std[0] < 0.5 for location in settled)
    last = settled[-1]
    assert last.heading_std is not None
    assert last.heading_std < 0.5
    assert all(abs(turned(location)) < 4 * (location.heading_std or 0.0) for location in settled[::10])
    assert np.linalg.norm(np.array(last.velocity) - TRACK.velocity(last.t)) < 0.15
    assert last.latitude == pytest.approx(48.1 + last.enu[1] / 111_200, abs=1e-5)
    assert all(view.reading.t - view.location.t < 0.5 for view in located(drive) if view.reading and view.location)


def test_fixes_that_jump_are_counted_and_hardly_move_it(drive: DrivenAlong) -> None:
    before = [view.location for view in located(drive) if view.location and view.location.t < 39.5][-1]
    last = drive.view.location
    assert last is not None
    assert before.outliers == 0
    assert last.outliers in {5, 6}
    assert len(last.far) == last.outliers
    assert off(last) < 1.5


def test_lines_carry_the_same(drive: DrivenAlong) -> None:
    view = located(drive)[-1]
    assert view.location is not None
    assert f"{view.location.heading:.2f}" in reading_line(view)
    assert f"{view.location.outliers} outliers" in reading_line(view)
    assert '"location": {"state": "located"' in json_line(view)
    early = next(view for view in drive.lines if view.location is not None)
    assert "not located, 0 fixes: no fix yet" in reading_line(early)
    assert '"state": "waiting"' in json_line(early)


def test_a_unit_that_restarts_is_located_again(drive: DrivenAlong) -> None:
    assert drive.restarted.location is not None
    assert not drive.restarted.location.is_located
    assert any("no longer known" in event.text for event in drive.restarted.events)


@pytest.mark.proof
def test_a_receiver_that_gives_positions_alone_is_enough() -> None:
    rig = driven_along(46.0, TRACK, replace(AUTOPILOT, states_velocity=False), TRUTH)
    assert not any("speed and course" in view.location.why for view in rig.lines if view.location)
    settled = [view.location for view in located(rig) if view.location and view.location.t > 38.0]
    assert len(settled) > 50
    assert all(off(location) < 4 * np.sqrt(2) * max(location.enu_std[:2]) for location in settled)
    assert all(abs(turned(location)) < 4 * (location.heading_std or 0.0) for location in settled[::10])
    assert (settled[-1].heading_std or 99.0) < 3.0
    assert np.linalg.norm(np.array(settled[-1].velocity) - TRACK.velocity(settled[-1].t)) < 0.5
