"""A camera of Video4Linux 2 as a port of bytes: its images as parts of a stream, for `drivers.camera.decoder`.

MJPEG is handed on as it is; what OpenCV converts becomes grey JPEG. ``X-Timestamp`` is the kernel's monotonic
stamp, ``X-Age`` how long ago that was. OpenCV waits 10 s for an image: a thread does, so that a read does not.
"""

import contextlib
import errno
import threading
import time
from collections.abc import Callable
from queue import Empty, Queue
from typing import Any

import numpy as np

from drivers.addresses import VideoDeviceAddress
from drivers.camera.decoder import part
from drivers.camera.jpeg import BEGIN
from drivers.errors import LinkLost, PortBusy, PortDenied, PortNotFound
from procedures.optional_libraries import ExtraMissing, opencv

S_PER_MS = 1e-3  # s
CLOSE_S = 1.0  # for an image under way; the thread lets go of the device when its wait is over
JPEG_QUALITY = 95  # of what the camera does not compress itself
MAX_WAITING_IMAGES = 8  # images that nobody has read; the oldest go
MAX_AGE_S = 10.0  # a stamp further off is not of the monotonic clock


class V4l2Port:
    """An open camera; ``capture`` is a ``cv2.VideoCapture``."""

    def __init__(
        self, name: str, capture: Any, timeout_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.name, self.dropped = name, 0
        self._capture, self._timeout_s, self._clock = capture, timeout_s, clock
        self._cv: Any = opencv()
        self._images: Queue[tuple[float, bytes] | None] = Queue()  # with their stamp; None once it is lost
        self._rest = b""
        self._lost = ""
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    def read(self, max_bytes: int) -> bytes:
        """Return what is left of an image, or the next one; empty after the timeout."""
        if not self._rest:
            self._rest = self._next()
        data, self._rest = self._rest[:max_bytes], self._rest[max_bytes:]
        return data

    def write(self, data: bytes) -> None:
        """Send nothing: a camera takes nothing."""

    def close(self) -> None:
        """Let go of the camera."""
        self._closing = True
        self._thread.join(CLOSE_S)

    def _next(self) -> bytes:
        try:
            taken = self._images.get(timeout=self._timeout_s)
        except Empty:
            return b""
        if taken is None:
            self._images.put(None)  # for who reads on
            raise LinkLost(self.name, self._lost)
        stamp, jpeg = taken
        age = self._clock() - stamp
        return part(jpeg, stamp, age if 0 <= age <= MAX_AGE_S else None)

    def _run(self) -> None:
        try:
            while not self._closing and self._take():
                pass
        except Exception as error:  # the edge of a thread, and OpenCV's errors: the port is lost, and says why
            self._lost = str(error).replace("\n", " ")
        finally:
            if self._lost:
                self._images.put(None)
            self._capture.release()

    def _take(self) -> bool:
        read, image = self._capture.read()
        if not read:
            self._lost = "it gives no more images"
            return False
        stamp = float(self._capture.get(self._cv.CAP_PROP_POS_MSEC)) * S_PER_MS
        jpeg = self._jpeg(image)
        if self._images.qsize() == MAX_WAITING_IMAGES:
            with contextlib.suppress(Empty):  # read just now
                self._images.get_nowait()
                self.dropped += 1
        self._images.put((stamp, jpeg))
        return True

    def _jpeg(self, image: Any) -> bytes:
        """Return a camera's own JPEG, or one of the grey or BGR image that OpenCV made of what it gave."""
        buffer: bytes = image.tobytes() if min(image.shape[:2]) == 1 else b""
        if buffer.startswith(BEGIN):
            return buffer
        grey = image if image.ndim == 2 else self._cv.cvtColor(image, self._cv.COLOR_BGR2GRAY)
        _, encoded = self._cv.imencode(
            ".jpg", np.ascontiguousarray(grey), [self._cv.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
        )
        return bytes(encoded)


def open_v4l2(address: VideoDeviceAddress, timeout_s: float) -> V4l2Port:
    """Open a camera by its device file.

    Raises `PortNotFound`, `PortDenied` or `PortBusy` if it is not there, may not be opened, or is open in another
    program; `PortNotFound` also where OpenCV is not installed.
    """
    try:
        cv = opencv()
    except ExtraMissing as error:
        raise PortNotFound(address.path, str(error).partition(";")[0], str(error).partition("; ")[2]) from error
    _look(address.path)
    capture = cv.VideoCapture(address.path, cv.CAP_V4L2)  # options here that it has not would keep it from opening
    if not capture.isOpened():
        raise PortNotFound(address.path, "no images can be had", "name one that `v4l2-ctl --list-devices` lists")
    try:
        set_up(capture, address, cv)
    except PortNotFound:
        capture.release()
        raise
    return V4l2Port(address.path, capture, timeout_s)


def set_up(capture: Any, address: VideoDeviceAddress, cv: Any) -> None:
    """Ask for MJPEG, size and rate; refuse another size, for which the intrinsics would be wrong."""
    mjpeg = cv.VideoWriter_fourcc(*"MJPG")
    capture.set(cv.CAP_PROP_FOURCC, mjpeg)
    if address.size is not None:
        capture.set(cv.CAP_PROP_FRAME_WIDTH, address.size[0])
        capture.set(cv.CAP_PROP_FRAME_HEIGHT, address.size[1])
    if address.rate_hz:
        capture.set(cv.CAP_PROP_FPS, round(address.rate_hz))
    if int(capture.get(cv.CAP_PROP_FOURCC)) == mjpeg:
        capture.set(cv.CAP_PROP_CONVERT_RGB, 0)  # the buffers as they are
    got = int(capture.get(cv.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv.CAP_PROP_FRAME_HEIGHT))
    if address.size is not None and got != address.size:
        found, asked = ("x".join(map(str, each)) for each in (got, address.size))
        advice = f"say size={found}, or one that `v4l2-ctl --list-formats-ext` lists"
        raise PortNotFound(address.path, f"it gives {found} px where {asked} was asked", advice)


def _look(path: str) -> None:
    """Say why a device cannot be opened where the kernel knows; OpenCV does not say."""
    try:
        with open(path, "rb"):
            pass
    except FileNotFoundError as error:
        raise PortNotFound(path, "no such device", "name one that `ls /dev/video*` lists") from error
    except PermissionError as error:
        raise PortDenied(path) from error
    except OSError as error:
        if error.errno == errno.EBUSY:
            raise PortBusy(path) from error
        raise PortNotFound(path, error.strerror or str(error), "name a camera such as /dev/video0") from error
