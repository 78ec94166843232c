"""A live camera and the same recorded: images in order, what is wrong with it, its file, what is on the disk."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from drivers.camera import CameraImage
from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.companions.truths import CameraTruth, camera_toml
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.fusion_folder.fusion_tables import camera_of, lens_of
from station.stream.auxiliary import RecordedCompanion
from station.stream.camera import CameraFeed, open_camera, read_description, recorded_images
from tests.patience import HANG_S
from tests.refusals import refused

pytest.importorskip("cv2", reason="opencv is not installed: the extra `camera`")
SMALL = CameraTruth(width=96, height=64, fx=60.0, fy=60.0, cx=47.5, cy=31.5, rate_hz=20.0)


class Clock:
    """The monotonic clock, `on` by as much as it is set."""

    on = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self.on


def until(feed: CameraFeed, holds: Callable[[], bool]) -> list[CameraImage]:
    """Advance until something holds, and return the images that came."""
    found, deadline = list[CameraImage](), time.monotonic() + HANG_S
    while not holds():
        assert time.monotonic() < deadline, feed.summary
        feed.advance(0.02)
        found.extend(feed.take(feed.up_to_ns))
    return found


@pytest.fixture
def camera() -> SimulatedCamera:
    return SimulatedCamera(Truth(), SMALL, seed=None)


def test_images_come_are_recorded_and_come_again(camera: SimulatedCamera, tmp_path: Path) -> None:
    with camera:
        (tmp_path / "eye.toml").write_text(camera_toml(SMALL, camera.url))
        folder = tmp_path / "r"
        folder.mkdir()
        with open_camera(read_description(tmp_path / "eye.toml"), folder) as feed:
            came = until(feed, lambda: feed.decoder.counters.images >= 10)
            stream = feed.stream()
    assert [image.host_ns for image in came] == sorted(image.host_ns for image in came)
    assert stream.name == f"camera {feed.address.name}"
    assert stream.samples == len(came)
    assert (stream.bad, stream.trouble) == (0, "")
    assert "0 no JPEG" in feed.summary
    assert (folder / "camera.toml").read_bytes() == (tmp_path / "eye.toml").read_bytes()
    again = list(recorded_images(folder))
    assert again[: len(came)] == came
    recorded = RecordedCompanion("camera", recorded_images(folder), {})
    half = came[4].came_ns
    before = sum(image.came_ns <= half for image in came)  # of a busy machine several may come at once
    assert list(recorded.take(half)) == came[:before]
    assert recorded.stream().samples == before >= 5
    assert list(recorded.take(came[-1].came_ns)) == came[before:]


def test_what_is_wrong_is_reported_and_over(camera: SimulatedCamera, tmp_path: Path) -> None:
    clock = Clock()
    with camera:
        (tmp_path / "eye.toml").write_text(camera_toml(SMALL, camera.url))
        with open_camera(read_description(tmp_path / "eye.toml"), tmp_path, clock) as feed:
            until(feed, lambda: feed.decoder.counters.images > 0)
            assert feed.trouble == ""
            clock.on = 2.0
            assert "no bytes for 1.8 s, expected images; check the camera" in feed.trouble
            clock.on = 0.0
            camera.plant("cut", HANG_S)
            until(feed, lambda: feed.decoder.counters.cut > 2)
            clock.on = 1.5  # bytes come all the time, the last image is as old
            until(feed, lambda: "hold no whole image" in feed.trouble)
            camera.faults.clear()
            until(feed, lambda: feed.trouble == "")
            camera.plant("unplug", HANG_S)
            until(feed, lambda: "tried again and again: check cable and power" in feed.trouble)
            camera.faults.clear()
            until(feed, lambda: feed.trouble == "" and feed.decoder.counters.images > 3)


def recording(camera: SimulatedCamera, folder: Path) -> tuple[Path, list[CameraImage]]:
    with camera:
        (folder / "eye.toml").write_text(camera_toml(SMALL, camera.url))
        with open_camera(read_description(folder / "eye.toml"), folder) as feed:
            until(feed, lambda: feed.decoder.counters.images >= 12)
    return next(folder.glob("camera_session_*.mcap")), list(recorded_images(folder))


def test_a_damaged_recording_is_refused(camera: SimulatedCamera, tmp_path: Path) -> None:
    path, _ = recording(camera, tmp_path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    with refused(DataRefused, ErrorCode.DATA, path.name):
        list(recorded_images(tmp_path))


URL = "camera:http://127.0.0.1:8080/stream"


def written(folder: Path, text: str) -> Path:
    path = folder / "eye.toml"
    path.write_text(text)
    return path


def test_what_the_simulated_camera_is_described_as_is_read(tmp_path: Path) -> None:
    truth = CameraTruth()
    found = read_description(written(tmp_path, camera_toml(truth, URL) + "time_offset_s = -0.03\n"))
    assert found.address.scheme == "camera"
    assert found.table.time_offset_s == -0.03
    camera = camera_of(found.table)
    assert np.allclose(camera.C_bc, truth.C_bc)
    assert np.allclose(camera.t_bc, truth.t_bc)
    assert np.allclose(lens_of(found.table).K, truth.K)
    assert found.content == (tmp_path / "eye.toml").read_bytes()


@pytest.mark.parametrize(
    ("old", "new", "line", "reported"),
    [
        (URL, "tcp://127.0.0.1:8080", 2, "camera:http://HOST:PORT/PATH"),
        (URL, "camera:nothing", 2, "camera:"),
        ("fx_px = 230.0", "fx_px = -1.0", 4, "fx_px"),
        ("fx_px = 230.0\n", "", 1, "fx_px"),
        ("std_px", "std_pixel", 3, "std_pixel"),
        ('"camera/1"', '"camera/2"', 1, "camera/1"),
    ],
)
def test_what_is_wrong_is_refused_with_its_line(
    tmp_path: Path, old: str, new: str, line: int, reported: str
) -> None:
    path = written(tmp_path, camera_toml(CameraTruth(), URL).replace(old, new))
    with pytest.raises(DataRefused) as refused:
        read_description(path)
    assert refused.value.line == line
    assert reported in str(refused.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataRefused, match="no readable file"):
        read_description(tmp_path / "none.toml")
