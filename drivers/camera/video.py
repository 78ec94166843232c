"""A camera by Video4Linux 2, or a video file: grey images with their time, one after the other.

A device's images carry the kernel's own stamp, seconds of the monotonic clock; a file's the time since its start.
"""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

from drivers.errors import LinkLost, PortNotFound
from procedures.fusion.vision.feature_tracker import Image
from procedures.optional_libraries import opencv

S_PER_MS = 1e-3  # s


def camera_images(path: str | Path, seconds: float = float("inf")) -> Iterator[tuple[float, Image]]:
    """Yield time [s] and image (h, w) of a camera or a video file until it ends or ``seconds`` have passed.

    Raises
    ------
    PortNotFound
        If there is none.
    LinkLost
        If a camera gives no more images.
    ExtraMissing
        If OpenCV is not installed.
    """
    cv: Any = opencv()
    is_device = Path(path).is_char_device()
    # no options for a device: Video4Linux's backend refuses to open where it lacks one, such as a timeout
    capture = cv.VideoCapture(str(path), cv.CAP_V4L2 if is_device else cv.CAP_ANY)
    if not capture.isOpened():
        raise PortNotFound(str(path), "no images can be had", "name a camera such as /dev/video0 or a video file")
    with ExitStack() as opened:
        opened.callback(capture.release)
        first: float | None = None
        while (found := capture.read())[0]:
            t = float(capture.get(cv.CAP_PROP_POS_MSEC)) * S_PER_MS
            first = t if first is None else first
            if t - first > seconds:
                return
            image = found[1]
            yield t, cast("Image", image if image.ndim == 2 else cv.cvtColor(image, cv.COLOR_BGR2GRAY))
        if is_device:
            raise LinkLost(str(path), "it gives no more images")
