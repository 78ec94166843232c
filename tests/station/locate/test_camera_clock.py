"""A camera whose stamps are off: told, found from its turns before anything begins, or said why it is not."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from procedures.fusion.alignment.alignment_result import Waiting
from station import cli
from station.files.fusion_folder import FusionLog, read_fusion
from station.files.fusion_folder.tracks import write_tracks
from station.locate.camera_clock import ClockedTracks, on_imu_clock, suspected_offset
from station.locate.locate_folder import location_text
from tests.procedures.fusion.motions import Eight
from tests.procedures.fusion.seen import tracks_of
from tests.station.locate.test_camera_source import table_of
from tests.station.locate.test_imu_source import write_flight

SECONDS = 10.0
LATE = -0.08  # s to be added to the stamps


def write_late(folder: Path, seconds: float, more: str = "") -> Path:
    """Write a flight whose camera stamps its frames too late, ``more`` said of it in ``[tracks]``."""
    made = write_flight(folder, seconds)
    with (made / "fusion.toml").open("a") as stream:
        stream.write(table_of() + more)
    write_tracks(made / "tracks.csv", tracks_of(Eight(seconds), 3).shifted(-LATE))
    return made


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_late(
        tmp_path_factory.mktemp("late") / "log", SECONDS, "time_offset_s = -0.07\ntime_offset_std_s = 0.01\n"
    )


@pytest.fixture(scope="module")
def log(folder: Path) -> FusionLog:
    return read_fusion(folder)


def said_of(log: FusionLog, **told: float | None) -> FusionLog:
    """Return a folder of which something else is told of the camera's clock."""
    assert log.table.tracks is not None
    return replace(log, table=log.table.model_copy(update={"tracks": log.table.tracks.model_copy(update=told)}))


def test_a_flight_is_located_once_the_offset_is_found(folder: Path, tmp_path: Path) -> None:
    assert cli.run(["locate", str(folder), "--source", "vision", "--json", str(tmp_path / "j.json")]) == 0
    said = json.loads((tmp_path / "j.json").read_text())
    offset, std = said["camera_time_offset_s"], said["camera_time_offset_std_s"]
    assert abs(offset - LATE) < 4 * std < 0.021
    assert said["initialised_at_s"] > 5.0
    assert said["error_m"]["online"]["mean"] < 0.1
    assert f"camera time offset    {offset * 1e3:.1f} +- {std * 1e3:.1f} ms" in location_text(said, 1)


def test_what_is_found_uses_nothing_later_than_it_is_known(log: FusionLog) -> None:
    whole = on_imu_clock(log)
    assert isinstance(whole, ClockedTracks)
    assert log.imu is not None
    assert log.tracks is not None
    later = log.imu.t > whole.since
    strange = replace(log.imu, omega_b=np.where(later[:, None], -log.imu.omega_b, log.imu.omega_b))
    moved = log.tracks.uv + np.where(log.tracks.t >= whole.since, 50.0, 0.0)[:, None]
    other = on_imu_clock(replace(log, imu=strange, tracks=replace(log.tracks, uv=moved)))
    assert isinstance(other, ClockedTracks)
    assert (other.offset, other.std) == (whole.offset, whole.std)


def test_an_offset_that_is_told_is_added(log: FusionLog) -> None:
    told = on_imu_clock(said_of(log, time_offset_s=LATE, time_offset_std_s=None))
    assert isinstance(told, ClockedTracks)
    assert log.tracks is not None
    assert np.allclose(told.tracks.t, log.tracks.t + LATE)
    assert told.std == 0.0
    assert told.since == -np.inf


def test_a_clock_that_nothing_was_said_of_is_suspected(tmp_path: Path) -> None:
    silent = read_fusion(write_late(tmp_path / "log", 14.0))
    assert re.search(
        r"stamps seem to be off by -(7|8)\d\.\d \+- [345]\.\d ms: say time_offset_s", suspected_offset(silent)
    )
    assert suspected_offset(said_of(silent, time_offset_s=0.0)) == ""  # told: as good as known


def test_what_does_not_turn_enough_is_exit_5_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = write_late(tmp_path / "log", 6.0, "time_offset_std_s = 0.1\n")
    assert isinstance(on_imu_clock(read_fusion(made)), Waiting)
    assert cli.run(["locate", str(made), "--source", "vision", "--json", str(tmp_path / "j.json")]) == 5
    assert "the camera's time offset: its clock is known to" in capsys.readouterr().err
    assert "turn unevenly" in json.loads((tmp_path / "j.json").read_text())["why_not"]
