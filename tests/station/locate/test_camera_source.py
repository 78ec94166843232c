"""`station locate --source vision`: a planted flight with a camera, whose clock may be off, through files."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.fusion_records import Waiting
from station import cli
from station.errors import DataRefused
from station.files.fusion_folder import FusionLog, read_fusion
from station.files.fusion_folder.fusion_tables import write_tracks
from station.locate.camera_source import ClockedTracks, on_imu_clock, suspected_offset
from station.locate.locate_folder import location_text
from tests.procedures.fusion.motions import CAMERA, Eight, tracks_of
from tests.refusals import refused
from tests.station.locate.test_imu_source import write_flight

SECONDS = 5.0


def table_of() -> str:
    """Return ``[tracks]`` of the planted camera."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = CAMERA.C_bc, CAMERA.t_bc
    return (
        f'[tracks]\nfile = "tracks.csv"\nstd_px = {CAMERA.std}\nfx_px = {CAMERA.fx}\nfy_px = {CAMERA.fy}\n'
        f"cx_px = {CAMERA.cx}\ncy_px = {CAMERA.cy}\nimu_from_camera = {T.tolist()}\n"
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A flight of some seconds with tracks."""
    made = write_flight(tmp_path / "log", SECONDS)
    with (made / "fusion.toml").open("a") as stream:
        stream.write(table_of())
    write_tracks(made / "tracks.csv", tracks_of(Eight(SECONDS), 3))
    return made


def test_a_flight_is_located_by_its_camera(folder: Path, tmp_path: Path) -> None:
    out, reported_file = tmp_path / "t.tum", tmp_path / "j.json"
    assert (
        cli.run(["locate", str(folder), "--source", "vision", "--out", str(out), "--json", str(reported_file)])
        == 0
    )
    reported = json.loads(reported_file.read_text())
    assert reported["source"] == "vision"
    assert reported["initialised_at_s"] < 3.0  # well before an IMU alone knows its heading
    assert reported["error_m"]["online"]["mean"] < 0.1
    assert reported["alignment"]["std"]["yaw_deg"] < 4.0
    assert abs(reported["gyro_bias_rad_s"][2] - 0.07) < 0.01
    assert np.diff(np.loadtxt(out)[:, 0]).max() < 0.1101


def test_tracks_come_back_as_they_were_written(folder: Path) -> None:
    log, made = read_fusion(folder), tracks_of(Eight(SECONDS), 3)
    assert log.tracks is not None
    assert log.camera is not None
    assert np.array_equal(log.tracks.feature, made.feature)
    assert np.abs(log.tracks.uv - made.uv).max() <= 0.0005 + 1e-9
    assert np.allclose(log.camera.C_bc, CAMERA.C_bc)


@pytest.mark.parametrize(
    ("rows", "line"),
    [
        ("0.1,7,10.0,10.0\n0.1,7,11.0,10.0\n", 3),
        ("0.1,7,10.0,10.0\n0.0,8,11.0,10.0\n", 3),
        ("0.1,7.5,10.0,10.0\n", 2),
        ("0.1,7,,10.0\n", 2),
    ],
)
def test_tracks_that_cannot_be_are_refused_with_their_line(folder: Path, rows: str, line: int) -> None:
    (folder / "tracks.csv").write_text("t_s,feature,u_px,v_px\n" + rows)
    with refused(DataRefused, None, "tracks.csv", line=line):
        read_fusion(folder)


def test_what_never_shows_how_far_it_moved_is_exit_5(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tracks = tracks_of(Eight(SECONDS), 3)
    first = tracks.t == tracks.t[0]
    t = np.repeat(np.arange(0.0, SECONDS, 0.1), int(first.sum()))
    frozen = FeatureTracks(t, np.tile(tracks.feature[first], len(t) // int(first.sum())),
                    np.tile(tracks.uv[first], (len(t) // int(first.sum()), 1)))  # fmt: skip
    write_tracks(folder / "tracks.csv", frozen)
    rows = np.loadtxt(folder / "gnss.csv", delimiter=",", skiprows=1)
    header = (folder / "gnss.csv").read_text().splitlines()[0]
    rows[:, 4:] = 0.0  # it stands, says GNSS too; the IMU that shakes contradicts both
    np.savetxt(folder / "gnss.csv", rows, "%.9f", ",", header=header, comments="")
    assert cli.run(["locate", str(folder), "--source", "vision"]) == 5
    reported = capsys.readouterr().err
    assert "needed: move further" in reported
    assert "without the camera" in reported


LATE_SECONDS = 10.0
LATE = -0.08  # s to be added to the stamps


def write_late(folder: Path, seconds: float, more: str = "") -> Path:
    """Write a flight whose camera stamps its frames too late, ``more`` said of it in ``[tracks]``."""
    made = write_flight(folder, seconds)
    with (made / "fusion.toml").open("a") as stream:
        stream.write(table_of() + more)
    write_tracks(made / "tracks.csv", tracks_of(Eight(seconds), 3).shifted(-LATE))
    return made


@pytest.fixture(scope="module")
def late_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_late(
        tmp_path_factory.mktemp("late") / "log", LATE_SECONDS, "time_offset_s = -0.07\ntime_offset_std_s = 0.01\n"
    )


@pytest.fixture(scope="module")
def log(late_folder: Path) -> FusionLog:
    return read_fusion(late_folder)


def reported_of(log: FusionLog, **specified: float | None) -> FusionLog:
    """Return a folder of which something else is told of the camera's clock."""
    assert log.table.tracks is not None
    return replace(
        log, table=log.table.model_copy(update={"tracks": log.table.tracks.model_copy(update=specified)})
    )


def test_a_flight_is_located_once_the_offset_is_found(late_folder: Path, tmp_path: Path) -> None:
    assert cli.run(["locate", str(late_folder), "--source", "vision", "--json", str(tmp_path / "j.json")]) == 0
    reported = json.loads((tmp_path / "j.json").read_text())
    offset, std = reported["camera_time_offset_s"], reported["camera_time_offset_std_s"]
    assert abs(offset - LATE) < 4 * std < 0.021
    assert reported["initialised_at_s"] > 5.0
    assert reported["error_m"]["online"]["mean"] < 0.1
    assert f"camera time offset    {offset * 1e3:.1f} +- {std * 1e3:.1f} ms" in location_text(reported, 1)


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


def test_an_offset_that_is_specified_is_added(log: FusionLog) -> None:
    specified = on_imu_clock(reported_of(log, time_offset_s=LATE, time_offset_std_s=None))
    assert isinstance(specified, ClockedTracks)
    assert log.tracks is not None
    assert np.allclose(specified.tracks.t, log.tracks.t + LATE)
    assert specified.std == 0.0
    assert specified.since == -np.inf


def test_a_clock_that_nothing_is_known_of_is_suspected(tmp_path: Path) -> None:
    silent = read_fusion(write_late(tmp_path / "log", 14.0))
    assert re.search(r"wrong by -(7|8)\d\.\d \+- [345]\.\d ms: state time_offset_s", suspected_offset(silent))
    assert suspected_offset(reported_of(silent, time_offset_s=0.0)) == ""  # specified: as good as known


def test_what_does_not_turn_enough_is_exit_5_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = write_late(tmp_path / "log", 6.0, "time_offset_std_s = 0.1\n")
    assert isinstance(on_imu_clock(read_fusion(made)), Waiting)
    assert cli.run(["locate", str(made), "--source", "vision", "--json", str(tmp_path / "j.json")]) == 5
    assert "the camera's time offset: its clock is known to" in capsys.readouterr().err
    assert "rotate it unevenly" in json.loads((tmp_path / "j.json").read_text())["why_not"]
