"""The monitor on simulated devices in memory: attitude against the truth, rest, alarms, recordings, lines."""

import csv
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.database import open_db
from procedures.campaign.campaign import UNKNOWN
from procedures.errors import ErrorCode
from procedures.positions import nominal_C_lb
from station.calibrated.calibration_choice import find_calibration
from station.calibrated.output_frame import body_axes
from station.errors import DataRefused
from station.files.mcap_files import read_step
from station.monitor.monitor import MonitorOptions
from station.monitor.text_lines import json_line, reading_line
from station.monitor.view import Alarm, MonitorView
from station.stream.connected_unit import Unit
from station.stream.recorder.sample_stream import check_raw_bytes
from tests.paths import ROOT
from tests.refusals import refused
from tests.station.monitor.rig import MonitorRig
from tests.station.monitor.views import BEHIND, LOCATED, RESTING

LATITUDE = np.radians(31.17)
FLAT = replace(Truth.example(5), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))
QUIET = replace(FLAT, gyro_turn_on_dph=0.0, accel_turn_on_g=0.0)


def down_of(view: MonitorView) -> np.ndarray:
    roll, pitch = np.radians([view.reading.roll, view.reading.pitch])
    return np.array([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])


def true_down(position: int) -> np.ndarray:
    """Return down in forward-right-down axes of a position on a level slab."""
    return body_axes("x,-y,-z") @ nominal_C_lb(position).T @ np.array([0.0, 0.0, -1.0])


@cache
def read_at(position: int) -> MonitorView:
    """Return what stands on the screen after 40 s at rest."""
    return MonitorRig(FLAT, MonitorOptions(latitude=LATITUDE), position=position).run(40.0)


@pytest.mark.parametrize("position", [1, 3, 6, 8, 9, 12])  # each face down once
def test_every_position_reads_as_it_stands_within_sigma(position: int) -> None:
    view = read_at(position)
    off = np.degrees(np.arccos(np.clip(down_of(view) @ true_down(position), -1, 1)))
    assert off < 3 * view.reading.sigma
    assert view.reading.sigma < 0.05
    assert view.reading.mode == "at rest"


def test_a_hand_move_is_followed_and_the_new_position_read() -> None:
    rig = MonitorRig(FLAT, MonitorOptions(latitude=LATITUDE))
    rig.run(30.0)
    rig.hands("place 1 20")
    view = rig.run(22.0, lambda view: view.reading.mode == "moving")
    assert view.reading.mode == "moving"
    view = rig.run(45.0, lambda view: view.reading.t > 53.0)
    off = np.degrees(np.arccos(np.clip(down_of(view) @ true_down(1), -1, 1)))
    assert off < 3 * view.reading.sigma
    assert off < 0.1


def test_it_shows_the_errors_with_and_without_the_calibration() -> None:
    options = MonitorOptions(latitude=LATITUDE, gravity=QUIET.local_gravity)
    errors = MonitorRig(QUIET, options).run(60.0).at_rest
    assert errors.seconds > 40
    assert errors.calibrated.level < 0.01 < 0.05 < errors.nominal.level
    assert errors.calibrated.drift < 0.3 < 0.8 < errors.nominal.drift
    assert abs(errors.calibrated.g) < 0.05 < 0.5 < abs(errors.nominal.g)
    assert "size" in errors.earth


def test_with_a_heading_the_whole_of_the_earths_rate_is_taken_off() -> None:
    options = MonitorOptions(
        latitude=LATITUDE, heading=0.0
    )  # position 9 is NWU: x, which is forward, points north
    errors = MonitorRig(QUIET, options).run(60.0).at_rest
    assert errors.calibrated.drift < 0.3
    wrong = MonitorRig(QUIET, replace(options, heading=np.radians(90.0))).run(60.0).at_rest
    assert wrong.calibrated.drift > 15.0


def test_half_a_minute_of_rest_determines_north_and_what_was_learnt_no_longer_holds_the_earths_rate() -> None:
    rig = MonitorRig(
        QUIET, MonitorOptions(latitude=LATITUDE), position=10
    )  # SEU: x, which is forward, points south
    before = rig.run(30.0).reading
    assert before.heading is None
    assert max(map(abs, before.bias)) > 8.0
    after = rig.run(40.0).reading
    heading, std = np.degrees(rig.monitor._track.north)  # noqa: SLF001
    assert abs((heading - 180.0 + 180.0) % 360.0 - 180.0) < 3 * std
    assert after.heading == pytest.approx(180.0, abs=3 * std) or after.heading == pytest.approx(
        -180.0, abs=3 * std
    )
    assert max(map(abs, after.bias)) < 3.0
    assert any("north from the Earth's rate" in text for text in rig.texts)
    assert np.degrees(np.arccos(np.clip(down_of(rig.view) @ true_down(10), -1, 1))) < 3 * after.sigma


def test_a_zero_changes_what_is_shown_and_nothing_else() -> None:
    one, other = MonitorRig(FLAT), MonitorRig(FLAT)
    for rig in (one, other):
        rig.run(20.0)
    one.execute("zero")
    for rig in (one, other):
        rig.run(10.0)
    assert one.view.reading == other.view.reading
    assert one.view.shown != other.view.shown
    assert abs(one.view.shown[0]) < 0.02
    one.execute("zero")
    assert one.view.shown == other.view.shown


def test_an_alarm_rings_once_and_ends_below_its_limit() -> None:
    rig = MonitorRig(FLAT, MonitorOptions(alarms=(Alarm("roll", 20.0),)))
    rig.run(20.0)
    assert rig.view.alarms == ()
    rig.hands("tilt 0 1 1")
    rig.run(70.0)
    assert rig.view.alarms[0].startswith("roll")
    rig.hands("place 9 20")
    rig.run(40.0)
    assert rig.view.alarms == ()
    begun = [view for view in rig.lines if any("ALARM" in event.text for event in view.events)]
    assert begun
    assert sum("ALARM" in text for text in rig.texts) == 1
    assert any("within 20 deg again" in text for text in rig.texts)


def test_it_records_bytes_and_counts_and_what_happened(tmp_path: Path) -> None:
    rig = MonitorRig(FLAT, folder=tmp_path)
    rig.execute("record")
    rig.run(10.0)
    rig.execute("mark")
    rig.execute("record")
    rig.run(5.0)
    rig.execute("record")
    rig.run(5.0)
    rig.monitor.close()
    assert check_raw_bytes(tmp_path / "recording.mcap", FORMATS["counts"]) == pytest.approx(500, abs=60)
    first, second = (read_step(tmp_path / name).device_ns for name in ("recording.mcap", "recording_2.mcap"))
    assert second[0] - first[-1] == pytest.approx(5e9, abs=1.1e9)
    rows = list(csv.DictReader((tmp_path / "events.csv").read_text().splitlines()))
    assert [row["event"] for row in rows] == ["record", "mark", "record", "record"]
    assert float(rows[1]["device_s"]) == pytest.approx(first[-1] / 1e9, abs=1.1)
    assert "recording.mcap" in (tmp_path / "SHA256SUMS").read_text()


def test_lost_frames_are_counted_and_the_attitude_goes_on() -> None:
    rig = MonitorRig(FLAT, faults=(Fault(kind="lost", at_s=15.0, every_s=5.0, count=3),))
    view = rig.run(40.0)
    assert view.streams[0].gaps >= 4
    assert view.streams[0].lost >= 12
    assert np.degrees(np.arccos(np.clip(down_of(view) @ true_down(9), -1, 1))) < 3 * view.reading.sigma


def test_what_a_drift_holds_of_the_earth_stands_next_to_it() -> None:
    assert RESTING.at_rest is not None
    held = "drift includes the Earth's rate: no --latitude"
    view = replace(RESTING, at_rest=replace(RESTING.at_rest, earth=held))
    assert reading_line(view).endswith(f"deg/h ({held})")
    assert json.loads(json_line(view))["at_rest"]["earth"] == held


@pytest.mark.parametrize(
    ("unit", "reported"),
    [(Unit(UNKNOWN, UNKNOWN, 0.02), "--model and --serial"), (Unit("FOG3", "7", 0.02), "FOG3 7")],
)
def test_without_calibration_and_scale_it_says_what_to_do(unit: Unit, reported: str, tmp_path: Path) -> None:
    database = str(tmp_path / "s.db")
    with open_db(database), refused(DataRefused, ErrorCode.CALIBRATION, reported):
        find_calibration(None, database, unit, FORMATS["counts"])
    with refused(DataRefused, None, "c.json"):
        find_calibration(tmp_path / "c.json", database, unit, FORMATS["counts"])


def test_a_calibration_of_another_model_is_refused() -> None:
    file = ROOT / "docs/examples/calibration.json"
    sister = find_calibration(file, None, Unit("EXAMPLE", "S124", 0.02), FORMATS["counts"])
    assert "S123" in sister.in_use.note
    with refused(DataRefused, ErrorCode.CALIBRATION, "EXAMPLE S123", "FOG3 7"):
        find_calibration(file, None, Unit("FOG3", "7", 0.02), FORMATS["counts"])


def test_a_location_that_lags_is_reported() -> None:
    assert reading_line(BEHIND).endswith("; 12 s behind")
    assert "behind" not in reading_line(LOCATED)
