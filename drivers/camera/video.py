"""A camera by Video4Linux 2, or a video file: grey images with their time, one after the other.

A device's images carry the kernel's own stamp, seconds of the monotonic clock; a file's the time since its start.
"""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, cast

from drivers.errors import LinkLost, PortNotFound
from procedures.fusion.optional_libraries import opencv
from procedures.fusion.vision.feature_tracker import Image

S_PER_MS = 1e-3  # s


def open_video(path: str | Path) -> "VideoCamera":
    """Open a camera or a video file, to be closed.

    Raises
    ------
    PortNotFound
        If there is none.
    ExtraMissing
        If OpenCV is not installed.
    """
    cv = opencv()
    device = Path(path).is_char_device()
    # no options for a device: Video4Linux's backend refuses to open where it lacks one, such as a timeout
    capture = cv.VideoCapture(str(path), cv.CAP_V4L2 if device else cv.CAP_ANY)
    if not capture.isOpened():
        raise PortNotFound(str(path), "no images can be had", "name a camera such as /dev/video0 or a video file")
    return VideoCamera(str(path), capture, cv, device)


class VideoCamera:
    """An open camera or video file."""

    def __init__(self, path: str, capture: Any, cv: Any, device: bool) -> None:
        self.path, self._capture, self._cv, self._device = path, capture, cv, device

    def close(self) -> None:
        """Let go of it."""
        self._capture.release()

    def images(self, seconds: float = float("inf")) -> Iterator[tuple[float, Image]]:
        """Yield time [s] and image (h, w) until a file ends or ``seconds`` have passed; raise `LinkLost`."""
        first: float | None = None
        while True:
            read, image = self._capture.read()
            if not read and self._device:
                raise LinkLost(self.path, "it gives no more images")
            if not read:
                return
            t = float(self._capture.get(self._cv.CAP_PROP_POS_MSEC)) * S_PER_MS
            first = t if first is None else first
            if t - first > seconds:
                return
            grey = image if image.ndim == 2 else self._cv.cvtColor(image, self._cv.COLOR_BGR2GRAY)
            yield t, cast("Image", grey)


def camera_images(path: str | Path, seconds: float = float("inf")) -> Iterator[tuple[float, Image]]:
    """Yield time [s] and image of a camera or a video file, and close it."""
    with closing(open_video(path)) as camera:
        yield from camera.images(seconds)
