"""The inertial window while it is being lived through: keyframes are added as samples and fixes come."""

import numpy as np

from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.imu_gaps import imu_gaps
from procedures.fusion.imu.inertial_increments import grid
from procedures.fusion.inner.inertial_window import InertialWindow
from procedures.fusion.inner.keyframes import Keyframes
from procedures.fusion.odometry import OdometryPose


class LiveWindow(InertialWindow):
    """Go through `poses` first, then call `go_on` for ever; what the lag has left behind is let go."""

    _since = 0.0  # s without a velocity
    _frames: Keyframes | None = None  # with room for more

    def go_on(self, t: float, imu: ImuSeries, fixes: GnssFixes, fix: int) -> OdometryPose:
        """Return the pose of a new keyframe at ``t`` [s].

        ``imu`` has the samples since the last keyframe; ``fixes`` are those so far and these, ``fix`` the one of
        them that stands at ``t``, -1 where none does.
        """
        k, before = len(self.frames.t), float(self.frames.t[-1])
        assert self.state is not None
        self.fixes = fixes
        self.frames = self._with_frame(k, t, fix)
        rate = np.array([np.interp(t, imu.t, imu.omega_b[:, i]) for i in range(3)], dtype=np.float64)
        self._imu.go_on(k, grid(imu, np.array([before, t])), self.frames.t, rate, imu_gaps(imu))
        self.state = self._advanced(k, self.state)
        self.factors, self.values = self._lib.NonlinearFactorGraph(), self._lib.Values()  # for no smoothed one
        self._since = 0.0 if self.state.has_velocity else self._since + t - before
        return self._pose(self.state, t - before, self._since)

    def _with_frame(self, k: int, t: float, fix: int) -> Keyframes:
        """Return the keyframes with another one, in arrays that double when they are full."""
        room = self._frames
        if room is None or k == len(room.t):
            room = self._frames = Keyframes(np.resize(self.frames.t, 2 * k), np.resize(self.frames.fix, 2 * k))
        room.t[k], room.fix[k] = t, fix
        return Keyframes(room.t[: k + 1], room.fix[: k + 1])
