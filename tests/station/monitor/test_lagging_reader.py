"""A reader next to the IMU that reports late: nothing waits for it, and a replay counts it in the same tick."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from station import cli
from station.errors import DataRefused
from station.monitor import auxiliary_inputs
from station.monitor.auxiliary_inputs import MAX_HOLD_S, AuxiliaryReaders
from station.monitor.text_lines import json_line
from station.stream.auxiliary import LATE_MESSAGES_FILE, note_late_messages, read_late_messages
from tests.drivers.simulated.drives import bends
from tests.refusals import refused
from tests.station.monitor.driving import DriveRig
from tests.station.monitor.unit import write_calibration

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
LAG_S = {(8.0, 12.0): 0.35, (15.0, 18.0): 1.3}  # from, to [s]: longer than a tick, and than some fixes


def lag(t: float) -> float:
    return next((late for (begin, end), late in LAG_S.items() if begin < t < end), 0.0)


def replayed(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    given = ["--speed", "0", "--json", "--aid", "gnss", "--calibration", str(write_calibration(tmp_path, TRUTH))]
    assert cli.run(["monitor", f"replay:{file}", *given]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_a_replay_takes_what_came_late_in_the_tick_that_took_it_then(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(auxiliary_inputs, "MAX_HOLD_S", -1.0)  # s: no tick waits
    folder = tmp_path / "r"
    folder.mkdir()
    rig = DriveRig(TRUTH, bends(30.0, still=6.0), AUTOPILOT, folder=folder, lag_s=lag)
    rig.run(24.0)
    rig.monitor.close()
    assert rig.writer is not None
    rig.writer.close()
    live = [json.loads(json_line(view)) for view in rig.lines]
    assert len(live) > 200
    late = read_late_messages(folder, "gnss")
    assert max(counted - read for read, counted in late.items()) > 1.2e9
    assert replayed(folder / "recording.mcap", tmp_path, capsys)[: len(live)] == live
    (folder / LATE_MESSAGES_FILE).unlink()
    assert replayed(folder / "recording.mcap", tmp_path, capsys)[: len(live)] != live


def test_a_table_that_was_cut_short_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    note_late_messages(tmp_path, "gnss", [1_700_000_000_000, 1_700_000_000_005], 1_700_100_000_000)
    note_late_messages(tmp_path, "wheel", [7], 9)
    with (tmp_path / LATE_MESSAGES_FILE).open("a") as table:
        table.write("gnss,1700200000000,17")
    assert read_late_messages(tmp_path, "gnss") == dict.fromkeys(
        (1_700_000_000_000, 1_700_000_000_005), 1_700_100_000_000
    )
    assert read_late_messages(tmp_path, "wheel") == {7: 9}
    assert read_late_messages(tmp_path / "nowhere", "gnss") == {}
    (tmp_path / LATE_MESSAGES_FILE).write_text("gnss,one,two\n")
    with refused(DataRefused, ErrorCode.DATA, LATE_MESSAGES_FILE):
        read_late_messages(tmp_path, "gnss")


@dataclass
class Reader:
    """One that says up to when it has told [ns]."""

    up_to_ns: int


def test_who_lags_is_waited_for_once_and_not_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(auxiliary_inputs, "monotonic", lambda: now[0])
    gnss, camera = Reader(10), Reader(10)
    readers = AuxiliaryReaders(gnss, camera)  # type: ignore[arg-type]
    assert readers.has_everything(10)
    camera.up_to_ns = 20
    assert not readers.has_everything(20)  # the receiver lags from here on
    now[0] += MAX_HOLD_S / 2
    assert not readers.has_everything(20)
    now[0] += MAX_HOLD_S
    assert readers.has_everything(20)
    camera.up_to_ns = 30
    assert readers.has_everything(30)  # at once: it still lags
    assert not readers.has_everything(40)  # the camera, which did not
    camera.up_to_ns = 40
    assert readers.has_everything(40)
    gnss.up_to_ns = 40
    assert readers.has_everything(40)
    camera.up_to_ns = 50
    assert not readers.has_everything(50)  # the receiver has caught up, and is waited for anew
