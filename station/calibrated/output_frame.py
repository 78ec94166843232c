"""The frame of calibrated samples: sensor, cube or forward-right-down, and the axes of a mounted IMU."""

from typing import Literal, get_args

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES
from station.errors import DataRefused

DEFAULT_AXES = "x,-y,-z"  # the IMU lies with Z up, X forward


def body_axes(text: str) -> FloatArray:
    """Return the rotation C (3, 3) that takes IMU axes to forward-right-down, of text such as ``x,-y,-z``.

    Raise `ValueError` if the axes are not three different ones, or left-handed.
    """
    words = [word.strip().lower() for word in text.split(",")]
    if len(words) != 3 or any(word.lstrip("+-") not in AXES for word in words):
        raise ValueError(f"found {text!r}, expected forward, right and down such as {DEFAULT_AXES}")
    if len({word[-1] for word in words}) < 3:
        raise ValueError(f"found {text!r}, which names an axis twice, expected one such as {DEFAULT_AXES}")
    C = np.zeros((3, 3))
    for row, word in enumerate(words):
        C[row, AXES.index(word[-1])] = -1.0 if word[0] == "-" else 1.0
    if not np.isclose(np.linalg.det(C), 1.0):
        raise ValueError(f"found {text!r}, a left-handed set, expected one such as {DEFAULT_AXES}")
    return C


Frame = Literal["sensor", "cube", "frd"]
FRAMES: tuple[Frame, ...] = get_args(Frame)


def frame_named(text: str) -> Frame:
    """Return a frame by its name, in capitals or not.

    Raise `ValueError` if there is none; says what is expected.
    """
    found = next((frame for frame in FRAMES if frame == text.lower()), None)
    if found is None:
        raise ValueError(f"found {text!r}, expected one of {', '.join(FRAMES)}")
    return found


def rotation_to(frame: str, axes: str | None) -> FloatArray:
    """Return the rotation C (3, 3) [1] that takes IMU axes to a frame.

    ``axes`` are, of "frd", the IMU axes that point forward, right, down; of "cube" the cube axes along which the
    IMU's point. Raise `DataRefused` if there is no such frame, or these are no axes.
    """
    if frame not in FRAMES:
        raise DataRefused("frame", None, repr(frame), f"one of {', '.join(FRAMES)}", "name one of them")
    if axes is not None and not isinstance(axes, str):
        raise DataRefused("axes", None, f"{axes!r}"[:60], f"text such as {DEFAULT_AXES}", "correct them")
    if frame == "sensor":
        if axes is not None:
            raise DataRefused("axes", None, f"{axes!r} of the sensor's frame", "none", "name frame cube or frd")
        return np.eye(3)
    try:
        if frame == "frd":
            return body_axes(axes or DEFAULT_AXES)
        C: FloatArray = body_axes(axes or "+x,+y,+z").T  # row q is the cube axis along which IMU axis q points
        return C
    except ValueError as error:
        found = str(error).removeprefix("found ").partition(", expected")[0]
        expected = f"three signed axes, as {DEFAULT_AXES}"
        raise DataRefused("axes", None, found, expected, "correct them") from None
