"""Which of the IMU's axes point forward, right and down in what it is mounted on."""

import numpy as np

from procedures.arrays import FloatArray

DEFAULT_AXES = "x,-y,-z"  # the IMU lies with Z up, X forward
_AXES = "xyz"


def body_axes(text: str) -> FloatArray:
    """Return the rotation C (3, 3) that takes IMU axes to forward-right-down, of text such as ``x,-y,-z``.

    Raises
    ------
    ValueError
        If the axes are not three different ones, or left-handed.
    """
    words = [word.strip().lower() for word in text.split(",")]
    if len(words) != 3 or any(word.lstrip("+-") not in _AXES or not word.lstrip("+-") for word in words):
        raise ValueError(f"found {text!r}, expected forward, right and down such as {DEFAULT_AXES}")
    if len({word[-1] for word in words}) < 3:
        raise ValueError(f"found {text!r}, which names an axis twice, expected one such as {DEFAULT_AXES}")
    C = np.zeros((3, 3))
    for row, word in enumerate(words):
        C[row, _AXES.index(word[-1])] = -1.0 if word[0] == "-" else 1.0
    if not np.isclose(np.linalg.det(C), 1.0):
        raise ValueError(f"found {text!r}, a left-handed set, expected one such as {DEFAULT_AXES}")
    return C
