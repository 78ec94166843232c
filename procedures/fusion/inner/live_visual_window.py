"""The window with a camera while it is lived through: keyframes are added as frames, samples and fixes come."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.gnss_velocity import CLIMB_SPAN_S, velocities
from procedures.fusion.imu.inertial_increments import grid
from procedures.fusion.inner.camera_keyframes import SPACING
from procedures.fusion.inner.visual_inertial_window import VisualInertialWindow
from procedures.fusion.odometry import OdometryPose


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
    parts = max(int(np.ceil((frame.t - last) / SPACING - 0.5)), 1)  # half a spacing more is no gap
    return [*(no_frame(t) for t in np.linspace(last, frame.t, parts + 1)[1:-1].tolist()), frame]


class LiveVisualWindow(VisualInertialWindow):
    """Go through `poses` first, then call `go_on` for ever."""

    def go_on(self, frame: Frame, imu: ImuSeries, fixes: GnssFixes) -> OdometryPose:
        """Return the pose of a new keyframe.

        ``imu`` has the samples since the last keyframe and around both ends; ``fixes`` those since some seconds
        before it.
        """
        part = self._between(grid(imu, np.array([self.t, frame.t])))
        recent = fixes.part(fixes.t > self.t - CLIMB_SPAN_S - 1.0)
        self._velocities = velocities(recent, imu, self.start.gyro_bias)
        self._aided = self._aided or bool(np.isfinite(recent.v_n[:, :2]).all(axis=1).any())
        return self._add(frame.t, part, frame.feature, frame.uv)
