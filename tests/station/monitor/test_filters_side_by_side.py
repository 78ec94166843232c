"""Two attitude laws on one live unit: on a bench, in a drive with a receiver, recorded, and replayed."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.attitude.filter_choice import parse_filters
from station import cli
from station.attitude.live_filters import ComplementaryFilterTrack
from station.attitude.live_kalman_filter import AidValues
from station.calibrated.rates_and_forces import RatesAndForces
from station.monitor.monitor import MonitorOptions
from station.monitor.text_lines import json_line, reading_line
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DriveRig, record_drive
from tests.station.monitor.rig import MonitorRig
from tests.station.monitor.unit import write_calibration

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
FLAT = replace(Truth.example(5), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0, airspeed_m_s=7.5)


@pytest.mark.parametrize("name", ["mixer", "paper"])
def test_a_complementary_filter_next_to_the_joint_filter_reads_the_bench_as_it_does(name: str) -> None:
    rig = MonitorRig(FLAT, MonitorOptions(filters=("joint", name), gains=ComplementaryGains.of_time_constant(3.0)))
    view = rig.run(40.0)
    joint, mixing = view.filters
    assert (joint.name, mixing.name) == ("joint", name)
    assert view.reading is not None
    assert (joint.roll, joint.pitch) == (view.reading.roll, view.reading.pitch)
    assert abs(mixing.roll) < 0.05
    assert abs(mixing.pitch) < 0.05
    document = json.loads(json_line(view))
    assert [one["law"] for one in document["laws"]] == ["joint", name]
    assert document["difference"]["roll_deg"] == pytest.approx(mixing.roll - joint.roll)
    assert document["difference"]["angle_deg"] == pytest.approx(
        np.hypot(mixing.roll - joint.roll, mixing.pitch - joint.pitch), rel=1e-3
    )
    assert "final_bias" not in document["laws"][1]  # no velocity, so that nothing says what it leaves out


def test_on_its_end_a_printed_filter_says_that_its_angles_fail() -> None:
    rig = MonitorRig(FLAT, MonitorOptions(filters=("joint", "paper")), position=1)  # X up
    view = rig.run(4.0)
    assert "use joint or mixer" in view.filters[1].note
    assert any("beyond 80 deg" in text for text in rig.texts)


@pytest.mark.parametrize(
    ("name", "aid"),
    [("mixer", "gnss"), ("paper", "gnss"), ("paper-whole", "airspeed-filter")],
)
def test_in_a_drive_a_filter_is_aided_and_says_where_it_will_settle(name: str, aid: str) -> None:
    rig = DriveRig(TRUTH, bends(40.0, still=6.0), AUTOPILOT, filters=("joint", name), aid=aid, locates=False)
    rig.run(36.0)
    seen = [
        view for view in rig.lines if view.filters and view.filters[1].settles is not None and view.reading.t > 12
    ]
    assert len(seen) > 100
    off = np.array([[view.filters[1].roll, view.filters[1].pitch] for view in seen])  # it drives level
    assert np.sqrt(np.mean(off**2)) < 3.0
    assert all(np.isfinite(view.filters[1].settles).all() for view in seen)
    assert "bias of" in reading_line(seen[-1])
    document = json.loads(json_line(seen[-1]))["laws"][1]["final_bias"]
    assert set(document) == {"roll_deg", "pitch_deg", "roll_std_deg", "pitch_std_deg"}


def test_forward_speed_keeps_a_turn_level_that_tilts_the_filter_without() -> None:
    def roll_rms(aid: str) -> float:
        rig = DriveRig(TRUTH, bends(40.0, still=6.0), AUTOPILOT, filters=("paper",), aid=aid, locates=False)
        rig.run(36.0)
        rolls = [view.filters[0].roll for view in rig.lines if view.filters and view.reading.t > 12]
        return float(np.sqrt(np.mean(np.square(rolls))))

    assert roll_rms("gnss") < 0.5 * roll_rms("none")


def test_what_two_filters_read_is_recorded_and_a_replay_reads_the_same_to_the_last_bit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    filters = ("joint", "paper-filter")
    file = record_drive(tmp_path / "r", TRUTH, bends(30.0, still=6.0), AUTOPILOT, 26.0, filters)
    recorded = (tmp_path / "r" / "laws.csv").read_bytes()
    rows = list(csv.DictReader(recorded.decode().splitlines()))
    assert len(rows) > 200
    last = rows[-1]
    apart = float(last["paper-filter_roll_deg"]) - float(last["joint_roll_deg"])
    assert float(last["difference_roll_deg"]) == pytest.approx(apart, abs=1e-12)
    again = tmp_path / "again"
    given = ["--aid", "gnss", "--filter", ",".join(filters), "--speed", "0", "--json", "--folder", str(again)]
    given += ["--calibration", str(write_calibration(tmp_path, TRUTH))]
    assert cli.run(["monitor", f"replay:{file}", *given]) == 0
    assert (again / "laws.csv").read_bytes() == recorded
    document = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["laws"][1]["roll_deg"] for line in document] == [
        float(row["paper-filter_roll_deg"]) for row in rows
    ]
    # the replay of a folder that names its laws needs no option
    replay = ["monitor", f"replay:{again}/recording.mcap", "--speed", "0", "--json", "--aid", "none", *given[-2:]]
    assert cli.run(replay) == 3
    assert "law paper-filter needs a velocity, found aid none" in capsys.readouterr().err
    assert cli.run([*replay, "--law", "joint,mixer", "--tau", "5"]) == 0
    assert [one["law"] for one in json.loads(capsys.readouterr().out.splitlines()[-1])["laws"]] == [
        "joint",
        "mixer",
    ]


@pytest.mark.parametrize("text", ["kalman", "joint,joint", "joint,paper,mixer"])
def test_filters_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  whatever its words
        parse_filters(text)


@pytest.mark.parametrize(
    ("arguments", "reported"),
    [
        (["--filter", "kalman"], "kalman"),
        (["--filter", "joint,paper-filter"], "--gnss"),
        (["--filter", "paper", "--alarm", "sigma=1"], "joint"),
    ],
)
def test_what_a_filter_cannot_use_is_reported_in_a_line(
    arguments: list[str], reported: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["monitor", "serial:///dev/ttyNONE", "--json", *arguments]) == 2
    error = capsys.readouterr().err
    assert reported in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("hz", [10, 100])
def test_the_velocity_filter_is_reported_to_diverge_after_a_minute_of_turning_at_any_rate(hz: int) -> None:
    track, size = ComplementaryFilterTrack("paper-filter", "airspeed-filter"), max(1, hz // 10)
    aid, notes = AidValues(airspeed=15.0), list[tuple[float, str]]()
    for first in range(0, 90 * hz, size):
        t = np.arange(first, first + size) / hz
        turns = (t >= 10.0)[:, None]
        rate = np.where(turns, np.radians(10.0) * np.array([0.0, 0.0, 1.0]), 0.0)
        force = np.array([0.0, 0.0, -9.80665]) + np.where(turns, [0.0, 15.0 * np.radians(10.0), 0.0], 0.0)
        if (found := track.take(t, RatesAndForces(rate, force), aid)) is not None and found.note:
            notes.append((float(t[-1]), found.note))
    assert "it diverges then" in notes[0][1]
    assert notes[0][0] == pytest.approx(70.0, abs=1.0)
