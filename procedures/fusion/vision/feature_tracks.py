"""What a camera saw: image points of features followed from frame to frame, and the camera that saw them.

``c`` is the camera: z along the view, x right, y down. Image points carry no distortion.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class PinholeCamera:
    """Pinhole intrinsics [px], 1 sigma of an image point ``std`` [px], and where it sits on the IMU.

    ``C_bc`` (3, 3) takes camera to IMU axes, ``t_bc`` (3,) [m] is the camera in the IMU's axes. Each row is taken
    ``row_time`` [s] later than the one above it, the stamp being that of row ``cy``; 0: all at once.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    std: float
    C_bc: FloatArray
    t_bc: FloatArray
    row_time: float = 0.0

    @property
    def ray_time(self) -> float:
        """How much later [s] what stands lower by 1 on the plane at depth 1 is taken."""
        return self.row_time * self.fy

    def rays(self, uv: FloatArray) -> FloatArray:
        """Return image points ``uv`` (n, 2) [px] on the plane at depth 1."""
        rays: FloatArray = (uv - [self.cx, self.cy]) / [self.fx, self.fy]
        return rays

    def pixels(self, rays: FloatArray) -> FloatArray:
        """Return points ``rays`` (n, 2) of the plane at depth 1 as image points [px]."""
        uv: FloatArray = rays * [self.fx, self.fy] + [self.cx, self.cy]
        return uv


@dataclass(frozen=True, slots=True, eq=False)
class FeatureTracks:
    """One row an observation: ``t`` (m,) [s] not falling, ``feature`` (m,), ``uv`` (m, 2) [px].

    Rows of one time are one frame; a feature stands in it once and keeps its number from frame to frame.
    """

    t: FloatArray
    feature: IntArray
    uv: FloatArray

    def shifted(self, offset: float) -> "FeatureTracks":
        """Return the tracks with ``offset`` [s] added to their time stamps."""
        return FeatureTracks(self.t + offset, self.feature, self.uv)

    def frames(self) -> tuple[FloatArray, IntArray]:
        """Return the times (n,) of the frames, and where their rows begin (n + 1,)."""
        first = np.flatnonzero(np.r_[True, np.diff(self.t) > 0]) if len(self.t) else np.zeros(0, np.int64)
        return self.t[first], np.r_[first, len(self.t)].astype(np.int64)
