"""What a camera saw at a keyframe, and the keyframes without a frame between them."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.fusion.inner.keyframes import between

SPACING = 0.1  # s between keyframes, at most
CLOSEST = 0.09  # s: frames that follow sooner are left out


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What a camera saw at ``t`` [s]: ``feature`` (m,) at ``uv`` (m, 2) [px], the lens's distortion taken off."""

    t: float
    feature: IntArray
    uv: FloatArray


def no_frame(t: float) -> Frame:
    """Return what is seen where there is no camera."""
    return Frame(t, np.zeros(0, np.int64), np.zeros((0, 2)))


def filled(last: float, frame: Frame) -> list[Frame]:
    """Return a frame with what stands between it and the keyframe at ``last`` [s]: a keyframe each `SPACING`."""
    return [*map(no_frame, between(last, frame.t, SPACING)), frame]
