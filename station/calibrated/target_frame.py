"""The frame in which calibrated samples are wanted: the sensors' own, the cube's, or forward-right-down."""

from typing import Literal, get_args

import numpy as np

from procedures.arrays import FloatArray
from station.calibrated.body_axes import DEFAULT_AXES, body_axes
from station.errors import DataRefused

Frame = Literal["sensor", "cube", "frd"]
FRAMES: tuple[Frame, ...] = get_args(Frame)


def frame_named(text: str) -> Frame:
    """Return a frame by its name, in capitals or not.

    Raises
    ------
    ValueError
        If there is none; says what is expected.
    """
    found = next((frame for frame in FRAMES if frame == text.lower()), None)
    if found is None:
        raise ValueError(f"found {text!r}, expected one of {', '.join(FRAMES)}")
    return found


def rotation_to(frame: str, axes: str | None) -> FloatArray:
    """Return the rotation C (3, 3) [1] that takes IMU axes to a frame.

    ``axes`` are, of "frd", the IMU axes that point forward, right, down; of "cube" the cube axes along which the
    IMU's point.

    Raises
    ------
    DataRefused
        If there is no such frame, or these are no axes.
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
        words = [word.strip().lower() for word in (axes or "+x,+y,+z").split(",")]
        C: FloatArray = body_axes(
            ",".join(words)
        ).T  # row q of C_sb is the cube axis along which IMU axis q points
        return C
    except ValueError as error:
        found = str(error).removeprefix("found ").partition(", expected")[0]
        expected = f"three signed axes, as {DEFAULT_AXES}"
        raise DataRefused("axes", None, found, expected, "correct them") from None
