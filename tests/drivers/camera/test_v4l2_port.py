"""A Video4Linux camera as a port of bytes, up to OpenCV's capture; there is no such device where tests run.

The capture is a video file read by OpenCV itself, or one that says what a device would.
"""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from drivers.address_parsing import parse_device_url
from drivers.camera import CameraDecoder, CameraImage
from drivers.camera.v4l2_port import MAX_WAITING_IMAGES, V4l2Port, set_up
from drivers.errors import LinkLost, PortNotFound
from drivers.ports import open_port
from tests.drivers.camera.images import HEIGHT, WIDTH, jpegs

cv2 = pytest.importorskip("cv2", reason="opencv is not installed")
GREY = np.tile(np.arange(WIDTH, dtype=np.uint8) * 3, (HEIGHT, 1))


class Device:
    """What a camera's capture gives, each buffer 0.1 s after the one before; then it waits to be released."""

    def __init__(self, buffers: list[np.ndarray], then: bool = True) -> None:
        self._buffers, self._at, self._then = iter(buffers), 50.0, then
        self.over = Event()

    def read(self) -> tuple[bool, np.ndarray | None]:
        self._at += 0.1
        buffer = next(self._buffers, None)
        if buffer is None and self._then:
            self.over.wait()
        return buffer is not None, buffer

    def get(self, what: int) -> float:
        assert what == cv2.CAP_PROP_POS_MSEC
        return self._at * 1e3

    def release(self) -> None:
        self.over.set()


def images_of(port: V4l2Port, count: int) -> Iterator[CameraImage]:
    decoder, got = CameraDecoder(), 0
    while got < count:
        for image in decoder.feed(port.read(1000), 10**18):
            got += 1
            yield image


def port_of(device: Device) -> V4l2Port:
    return V4l2Port("/dev/video9", device, 5.0, clock=lambda: 51.0)


def test_a_cameras_own_jpeg_is_handed_on_as_it_is_with_the_kernels_stamp() -> None:
    device = Device([np.frombuffer(jpeg, np.uint8)[None] for jpeg in jpegs()])
    port = port_of(device)
    got = list(images_of(port, 4))
    device.over.set()
    port.close()
    assert [image.jpeg for image in got] == [*jpegs()]
    assert port.dropped == 0
    assert [image.device_ns for image in got] == [50_100_000_000 + i * 100_000_000 for i in range(4)]
    assert [10**18 - image.host_ns for image in got] == [900_000_000 - i * 100_000_000 for i in range(4)]


def test_a_camera_that_gives_no_more_images_is_lost_after_those_it_gave() -> None:
    with closing(port_of(Device([GREY], then=False))) as port:
        assert len(list(images_of(port, 1))) == 1
        with pytest.raises(LinkLost):
            port.read(1000)


def test_nothing_is_nothing_and_old_images_make_room() -> None:
    device = Device([np.frombuffer(jpegs()[i % 4], np.uint8)[None] for i in range(MAX_WAITING_IMAGES + 5)])
    port = V4l2Port("/dev/video9", device, 0.01)
    while port.dropped < 5:  # nobody reads
        pass
    assert len(list(images_of(port, MAX_WAITING_IMAGES))) == MAX_WAITING_IMAGES
    assert port.read(1000) == b""
    device.over.set()
    port.close()


def test_a_video_read_by_opencv_gives_its_images(tmp_path: Path) -> None:
    path = tmp_path / "seen.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (WIDTH, HEIGHT), isColor=False)
    for shift in range(5):
        writer.write(np.roll(GREY, shift, axis=1))
    writer.release()
    with closing(V4l2Port(str(path), cv2.VideoCapture(str(path)), 5.0)) as port:
        got = list(images_of(port, 5))
    assert np.diff([image.device_ns for image in got]) == pytest.approx(1e8, abs=1e6)
    assert {image.host_ns for image in got} == {10**18}  # a time in a file is no age


class Settings(dict[int, float]):
    """What a capture can be set to; ``refused`` stays as it is, as of a camera that cannot."""

    refused: tuple[int, ...] = ()

    def set(self, what: int, value: float) -> bool:
        self[what] = self[what] if what in self.refused else value
        return what not in self.refused

    def get(self, what: int, default: float = 0.0) -> float:  # type: ignore[override]
        return super().get(what, default)


def test_mjpeg_is_asked_for_and_another_size_than_asked_refused() -> None:
    address = parse_device_url("camera:/dev/video0?size=320x240&rate=20")
    width, mjpeg = cv2.CAP_PROP_FRAME_WIDTH, cv2.VideoWriter_fourcc(*"MJPG")
    able = Settings({cv2.CAP_PROP_CONVERT_RGB: 1, width: 640, cv2.CAP_PROP_FRAME_HEIGHT: 480})
    set_up(able, address, cv2)
    assert (able[width], able[cv2.CAP_PROP_FRAME_HEIGHT], able[cv2.CAP_PROP_FPS]) == (320, 240, 20)
    assert (able[cv2.CAP_PROP_FOURCC], able[cv2.CAP_PROP_CONVERT_RGB]) == (mjpeg, 0)
    grey = Settings({cv2.CAP_PROP_CONVERT_RGB: 1, cv2.CAP_PROP_FOURCC: 0, width: 640})
    grey.refused = (cv2.CAP_PROP_FOURCC, width)
    with pytest.raises(PortNotFound, match=r"640x240.*320x240.*size=640x240"):
        set_up(grey, address, cv2)
    assert grey[cv2.CAP_PROP_CONVERT_RGB] == 1  # OpenCV converts what is no MJPEG


def test_no_device_is_reported(tmp_path: Path) -> None:
    with pytest.raises(PortNotFound, match="/dev/video"):
        open_port("camera:/dev/video77")
    with pytest.raises(PortNotFound):
        open_port("camera:/dev/null")
