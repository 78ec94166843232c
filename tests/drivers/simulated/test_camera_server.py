"""The simulated camera on its port: others can read it, and it goes by the clock of what it stands next to."""

from contextlib import closing

import numpy as np
import pytest

from drivers.camera import CameraDecoder
from drivers.ports import open_port
from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.companions.truths import CameraTruth
from drivers.simulated.truth import Truth

cv2 = pytest.importorskip("cv2", reason="opencv is not installed")


class Clock:
    """A device whose true time is set."""

    true_time = 0.0


def test_opencv_reads_it_as_any_network_camera() -> None:
    with SimulatedCamera(Truth(), seed=None) as camera:
        capture = cv2.VideoCapture(camera.url.removeprefix("camera:"))
        got, image = capture.read()
        capture.release()
    assert got
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(float)
    assert np.abs(grey - camera.images.image(0.0)).mean() < 3.0  # JPEG; it stands, so that all images are the same


def test_an_image_is_sent_once_its_latency_is_over() -> None:
    clock, truth = Clock(), CameraTruth(rate_hz=10.0, latency_s=0.25, clock_offset_s=0.0, clock_ppm=0.0)
    with SimulatedCamera(Truth(), truth, imu=clock) as camera, closing(open_port(camera.url)) as port:
        decoder, sent = CameraDecoder(), list[tuple[float, float]]()
        while len(sent) < 8:
            images = decoder.feed(port.read(2**20), 0)
            sent += [(clock.true_time, (image.device_ns or 0) / 1e9) for image in images]
            clock.true_time += 0.05
    assert min(now - taken for now, taken in sent) >= 0.25 - 1e-6
    taken = np.array([taken for _, taken in sent])
    assert taken * 10 == pytest.approx(np.rint(taken * 10), abs=1e-4)  # at their times, whenever they are rendered
    assert (np.diff(taken) > 0).all()


def test_a_failure_is_kept_for_whoever_asks() -> None:
    with SimulatedCamera(Truth()) as camera, closing(open_port(camera.url)) as port:
        camera.images.room = None  # type: ignore[assignment]
        while camera.failure is None:
            port.read(2**20)
    assert isinstance(camera.failure, AttributeError)
