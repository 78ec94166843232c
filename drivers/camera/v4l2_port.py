"""A camera of Video4Linux 2 as a port of bytes: its images as parts of a stream, for `drivers.camera.decoder`.

MJPEG is asked for, and its buffers are handed on as they are; what a camera without it gives OpenCV converts, and
it becomes grey JPEG. ``X-Timestamp`` is the kernel's stamp of the monotonic clock, ``X-Age`` how long ago that was
when the part is handed on. OpenCV waits 10 s for an image: a thread does, so that a read returns in time.
"""

import errno
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from drivers.camera.address import CameraUrl
from drivers.camera.jpeg import BEGIN
from drivers.camera.multipart import part
from drivers.errors import LinkLost, PortBusy, PortDenied, PortNotFound
from procedures.fusion.optional_libraries import ExtraMissing, opencv

S_PER_MS = 1e-3  # s
CLOSE_S = 1.0  # for an image under way; the thread lets go of the device when its wait is over
JPEG_QUALITY = 95  # of what the camera does not compress itself
MAX_WAITING_IMAGES = 8  # images that nobody has read; the oldest go
MAX_AGE_S = 10.0  # a stamp further off is not of the monotonic clock


class Capture(Protocol):
    """What is used of ``cv2.VideoCapture``."""

    def read(self) -> tuple[bool, Any]:
        """Return whether there is an image, and it."""
        ...

    def get(self, what: int) -> float:
        """Return a property."""
        ...

    def release(self) -> None:
        """Let go of the device."""
        ...


class V4l2Port:
    """An open camera."""

    def __init__(
        self, name: str, capture: Capture, timeout_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.name, self.dropped = name, 0
        self._capture, self._timeout_s, self._clock = capture, timeout_s, clock
        self._cv: Any = opencv()
        self._came = threading.Condition()
        self._images: deque[tuple[float, bytes]] = deque()
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
        with self._came:
            self._closing = True
        self._thread.join(CLOSE_S)

    def _next(self) -> bytes:
        with self._came:
            self._came.wait_for(lambda: self._images or self._lost, self._timeout_s)
            if not self._images:
                if self._lost:
                    raise LinkLost(self.name, self._lost)
                return b""
            stamp, jpeg = self._images.popleft()
        age = self._clock() - stamp
        return part(jpeg, stamp, age if 0 <= age <= MAX_AGE_S else None)

    def _run(self) -> None:
        try:
            while not self._closing and not self._lost:
                self._take()
        except Exception as error:  # the edge of a thread, and OpenCV's errors: the port is lost, and says why
            self._lose(str(error).replace("\n", " "))
        finally:
            self._capture.release()

    def _take(self) -> None:
        read, image = self._capture.read()
        if not read:
            self._lose("it gives no more images")
            return
        stamp = float(self._capture.get(self._cv.CAP_PROP_POS_MSEC)) * S_PER_MS
        jpeg = self._jpeg(image)
        with self._came:
            if len(self._images) == MAX_WAITING_IMAGES:
                self._images.popleft()
                self.dropped += 1
            self._images.append((stamp, jpeg))
            self._came.notify_all()

    def _lose(self, reason: str) -> None:
        with self._came:
            self._lost = reason
            self._came.notify_all()

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


def open_v4l2(address: CameraUrl, timeout_s: float) -> V4l2Port:
    """Open a camera by its device file.

    Raises
    ------
    PortNotFound, PortDenied, PortBusy
        If it is not there, may not be opened, or is open in another program;
        `PortNotFound` also where OpenCV is not installed.
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


def set_up(capture: Any, address: CameraUrl, cv: Any) -> None:
    """Ask for MJPEG, size and rate; refuse another size, for which the intrinsics would be wrong."""
    mjpeg = cv.VideoWriter_fourcc(*"MJPG")
    capture.set(cv.CAP_PROP_FOURCC, mjpeg)
    if address.size is not None:
        capture.set(cv.CAP_PROP_FRAME_WIDTH, address.size[0])
        capture.set(cv.CAP_PROP_FRAME_HEIGHT, address.size[1])
    if address.rate_hz is not None:
        capture.set(cv.CAP_PROP_FPS, round(address.rate_hz))
    if int(capture.get(cv.CAP_PROP_FOURCC)) == mjpeg:
        capture.set(cv.CAP_PROP_CONVERT_RGB, 0)  # the buffers as they are
    got = int(capture.get(cv.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv.CAP_PROP_FRAME_HEIGHT))
    if address.size is not None and got != address.size:
        found, asked = ("x".join(map(str, each)) for each in (got, address.size))
        advice = f"say size={found}, or one that `v4l2-ctl --list-formats-ext` lists"
        raise PortNotFound(address.path, f"it gives {found} px where {asked} was asked", advice)


def _look(path: str) -> None:
    """Say why a device cannot be opened where the kernel tells; OpenCV does not."""
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
