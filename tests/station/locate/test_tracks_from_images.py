"""``station locate --images``: rendered images and video become ``[tracks]``; what is no image is refused."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from drivers.errors import PortNotFound
from procedures.errors import ErrorCode
from procedures.fusion.vision.feature_tracker import LensModel
from station import cli
from station.errors import CannotWrite, DataRefused
from station.files.fusion_folder import read_fusion
from station.locate.tracks_from_images import camera_images, follow_all, listed_images, make_tracks
from tests.procedures.fusion.rendered import FOCAL, HEIGHT, WIDTH, Scene, frames
from tests.refusals import refused
from tests.station.files.fusion_folder.drive_folders import write_folder

cv2 = pytest.importorskip("cv2", reason="opencv is not installed")
TRACKS = f"""[tracks]
file = "tracks.csv"
fx_px = {FOCAL}
fy_px = {FOCAL}
cx_px = {WIDTH / 2}
cy_px = {HEIGHT / 2}
imu_from_camera = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
"""
LENS = LensModel(FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, np.zeros(4))


@cache
def seen() -> list[tuple[float, np.ndarray]]:
    return list(frames(Scene(cv2), 0.6))


@pytest.fixture
def images(tmp_path: Path) -> Path:
    """A folder of images."""
    folder = tmp_path / "cam0"
    folder.mkdir()
    lines = ["t_s,file"]
    for t, image in seen():
        name = f"{round(t * 1000):04d}.png"
        assert cv2.imwrite(str(folder / name), image)
        lines.append(f"{t:.3f},{name}")
    (folder / "images.csv").write_text("\n".join(lines) + "\n")
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A fusion folder whose tracks are still to be made."""
    made = write_folder(tmp_path / "log", seconds=5.0)
    with (made / "fusion.toml").open("a") as stream:
        stream.write(TRACKS)
    return made


def test_images_become_the_tracks_of_a_folder(folder: Path, images: Path) -> None:
    assert make_tracks(folder, images, np.inf) == folder / "tracks.csv"
    tracks, same = read_fusion(folder).tracks, follow_all(seen(), LENS)
    assert tracks is not None
    assert np.array_equal(tracks.feature, same.feature)
    assert np.abs(tracks.uv - same.uv).max() < 0.001
    assert len(tracks.frames()[0]) == len(seen())
    shorter = follow_all(listed_images(images, 0.25), LENS)
    assert len(shorter.frames()[0]) == 3


def test_a_video_gives_the_same_images_with_their_time(tmp_path: Path) -> None:
    path = tmp_path / "seen.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (WIDTH, HEIGHT), isColor=False)
    assert writer.isOpened()
    for _, image in seen():
        writer.write(image)
    writer.release()
    got = list(camera_images(path))
    assert np.allclose(np.diff([t for t, _ in got]), 0.1, atol=1e-3)
    assert len(got) == len(seen())
    assert np.abs(got[2][1].astype(float) - seen()[2][1]).mean() < 6.0  # JPEG
    assert len(list(camera_images(path, 0.25))) == 3


def test_the_command_follows_images_and_says_when_they_show_no_motion_it_can_use(
    folder: Path, images: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["locate", str(folder), "--images", str(images)]) == 5  # a standing IMU before a moving view
    assert (folder / "tracks.csv").exists()
    assert "cannot be determined" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("lines", "number"),
    [
        ("time,file\n", 1),
        ("t_s,file\n0.0,0000.png\n0.0,0100.png\n", 3),
        ("t_s,file\nnow,0000.png\n", 2),
        ("t_s,file\n0.0,images.csv\n", 2),
        ("t_s,file\n0.0,gone.png\n", 2),
        ("t_s,file\n0.0,../log/fusion.toml\n", 2),
    ],
)
def test_images_that_cannot_be_are_refused_in_one_line(images: Path, lines: str, number: int) -> None:
    (images / "images.csv").write_text(lines)
    with refused(DataRefused, ErrorCode.DATA, "images.csv", line=number) as caught:
        list(listed_images(images))
    assert "\n" not in str(caught.value)


def test_no_camera_is_a_device_fault(tmp_path: Path) -> None:
    with refused(PortNotFound, ErrorCode.DEVICE):
        list(camera_images(tmp_path / "video7"))


@pytest.mark.parametrize(("option", "name"), [("--out", "images.csv"), ("--json", "0100.png")])
def test_what_is_seen_is_not_written_over(
    option: str, name: str, folder: Path, images: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (images / name).read_bytes()
    assert cli.run(["locate", str(folder), "--images", str(images), option, str(images / name)]) == 2
    assert "it is read here" in capsys.readouterr().err
    assert (images / name).read_bytes() == before
    assert not (folder / "tracks.csv").exists()


@pytest.mark.parametrize("name", ["imu.csv", "images.csv"])
def test_tracks_are_not_written_over_another_file(name: str, folder: Path, images: Path) -> None:
    toml = folder / "fusion.toml"
    toml.write_text(toml.read_text().replace("tracks.csv", name))
    for file in images.iterdir():
        file.rename(folder / file.name)
    before = (folder / name).read_bytes()
    with refused(CannotWrite, ErrorCode.CANNOT_WRITE):
        make_tracks(folder, folder, np.inf)
    assert (folder / name).read_bytes() == before
