"""A drive in memory with a camera: located as soon as it moves, also in the dark, judged by its own sigma."""

import numpy as np
import pytest

from drivers.simulated.companions.truths import AutopilotTruth
from station.locate.location import Location
from station.monitor.text_lines import json_line, reading_line
from station.monitor.view import MonitorView
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DrivenAlong, DriveRig, driven_along
from tests.station.monitor.test_driving import TRUTH, off, turned

pytestmark = pytest.mark.proof

TRACK = bends(60.0, still=16.0)  # as of test_driving
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
DARK = (28.0, 33.0)


@pytest.fixture(scope="module")
def drive() -> DrivenAlong:
    return driven_along(38.0, TRACK, AUTOPILOT, TRUTH, sees=(0.04, DARK), specified=-0.04)


def located(drive: DriveRig | DrivenAlong) -> list[tuple[MonitorView, Location]]:
    return [(view, view.location) for view in drive.lines if view.location and view.location.is_located]


def test_it_is_located_within_three_seconds_of_setting_off(drive: DrivenAlong) -> None:
    waiting = [view.location for view in drive.lines if view.location and not view.location.is_located]
    assert waiting[-1].why.startswith("the image moves by")
    assert "move further; without the camera: at rest" in waiting[-1].why
    assert 16.0 < located(drive)[0][1].t < 19.0


def test_heading_and_place_are_the_truth_within_their_sigma(drive: DrivenAlong) -> None:
    settled = [location for _, location in located(drive) if location.t > 19.0]
    assert len(settled) > 150
    assert all(off(each) < 4 * np.sqrt(2) * max(each.enu_std[:2]) for each in settled)
    assert all(abs(turned(each)) < 4 * (each.heading_std or 0.0) for each in settled[::5])
    assert settled[-1].heading_std is not None
    assert settled[-1].heading_std < 0.4
    last = settled[-1]
    assert np.linalg.norm(np.array(last.velocity) - TRACK.velocity(last.t)) < 0.15
    assert all(view.reading.t - each.t < 0.5 for view, each in located(drive) if view.reading)


def test_it_goes_on_without_images_and_says_so(drive: DrivenAlong) -> None:
    reported = {
        location.camera for view, location in located(drive) if view.reading and DARK[0] < view.reading.t < 33.0
    }
    assert "no image for 4 s" in reported
    after = [location for view, location in located(drive) if view.reading and view.reading.t > 33.5]
    assert all(location.camera == "80 features, stamps 40 ms late" for location in after)
    times = [location.t for _, location in located(drive)]
    assert max(np.diff(times)) < 0.35


def test_lines_and_streams_report_the_camera(drive: DrivenAlong) -> None:
    view, location = located(drive)[-1]
    assert reading_line(view).endswith(f"; camera: {location.camera}")
    assert f'"camera": "{location.camera}"' in json_line(view)
    assert [stream.name for stream in view.streams][-1] == "camera simulated"


def test_what_is_wrong_with_the_camera_is_reported_once_and_when_it_is_over() -> None:
    rig = DriveRig(TRUTH, TRACK, AUTOPILOT, sees=(0.04, (0.0, 0.0)), specified=-0.04)
    for trouble in ("", "eye: no bytes for 2.0 s", "eye: no bytes for 2.1 s", ""):
        assert rig.sight is not None
        rig.sight.trouble = trouble
        rig.run(0.3)
    reported = [event.text for event in rig.view.events if "eye" in event.text or "camera" in event.text]
    assert reported == ["eye: no bytes for 2.0 s", "camera simulated: well again"]
