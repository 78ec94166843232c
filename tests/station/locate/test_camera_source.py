"""``station locate --source vision``: a planted flight with a camera through files, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from procedures.fusion.vision.feature_tracks import FeatureTracks
from station import cli
from station.errors import DataRefused
from station.files.fusion_folder import read_fusion
from station.files.fusion_folder.tracks import write_tracks
from tests.procedures.fusion.motions import Eight
from tests.procedures.fusion.seen import CAMERA, tracks_of
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
    out, said_file = tmp_path / "t.tum", tmp_path / "j.json"
    assert cli.run(["locate", str(folder), "--source", "vision", "--out", str(out), "--json", str(said_file)]) == 0
    said = json.loads(said_file.read_text())
    assert said["source"] == "vision"
    assert said["initialised_at_s"] < 3.0  # well before an IMU alone knows its heading
    assert said["error_m"]["online"]["mean"] < 0.1
    assert said["alignment"]["std"]["yaw_deg"] < 4.0
    assert abs(said["gyro_bias_rad_s"][2] - 0.07) < 0.01
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
    said = capsys.readouterr().err
    assert "needed: move further" in said
    assert "without the camera" in said
