"""The inner layer with a camera: tracks with IMU and GNSS velocity, in a window of ten keyframes.

Landmarks and where the camera sits are fitted with poses, velocities and biases: reprojection with Huber's loss.
What leaves is marginalised with all its sights; landmarks that are still followed stay in the prior.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment_in_motion import ACCEL_NOISE_FACTOR
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuNoise, ImuSeries
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.inner_window import (
    FRAME_STD,
    FRAME_WALK,
    FREE_VELOCITY,
    KNOWN_STD,
    ORIGIN_STD,
    OUTAGE_S,
    InnerWindow,
)
from procedures.fusion.inner.landmarks import residuals
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.inner.window_problem import BackSubstitution, Prior, walked
from procedures.fusion.inner.window_state import (
    COMMON,
    FRAME,
    FRAME_SPACING_S,
    HEADING,
    MIN_FRAME_SPACING_S,
    OFFSET,
    Frame,
    Normal,
    WindowState,
    keyframes,
)
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.preintegration import Preintegrated

FRAMES, ROUNDS = 10, 4
HEADING_WALK = 5e-4  # rad/sqrt(s) by which the window's own frame drifts against n
OUTLIER_SIGMAS = 4.0  # whitened length of a sight (two axes) that is no match: 3e-4 by chance
CAMERA_TURN = np.radians(1.0)  # 1 sigma of what was given of the camera's place
CAMERA_PLACE = 0.02  # m
FREE_HEADING = 0.3  # rad on the first attitude: the alignment's own data are used again from there on
FREE_TILT = 0.1
FIXED = 1e-4  # rad, the heading of the window's own frame
OFFSET_WALK = 3e-4  # s/sqrt(s): 50 ppm of a camera's own clock are 3 ms in a minute
DRIFT_FACTOR = 2.0  # of the drift that the window states: measured on real IMUs, docs/how-to/locate-vision.md


@dataclass(frozen=True, slots=True, eq=False)
class VisionSettings:
    """What is given; ``frames`` is the window's length.

    ``offset_std`` [s] is how well the camera's stamps are known by the IMU's clock: where it is not 0, what they
    are off is fitted too.
    """

    site: Site
    camera: PinholeCamera
    antenna: LeverArm
    frames: int = FRAMES
    offset_std: float = 0.0


def beginning(
    start: AlignmentState, camera: PinholeCamera, noise: ImuNoise, offset_std: float = 0.0,
    wheel_std: float = KNOWN_STD,
) -> tuple[WindowState, Prior]:  # fmt: skip
    """Return the first keyframe, and the little that is known of it: its heading is the window's own."""
    none = np.zeros((1, 3))
    state = WindowState(
        start.C_nb[None], none, start.v_n[None], start.gyro_bias[None], start.accel_bias[None],
        camera.C_bc, camera.t_bc, 0.0, np.zeros((0, 3)), rate=none if offset_std or camera.row_time else None,
        line=camera.ray_time,
    )  # fmt: skip
    frame = np.repeat([FREE_TILT, ORIGIN_STD, FREE_VELOCITY, noise.gyro_bias, noise.accel_bias], 3)
    camera_std = np.repeat([CAMERA_TURN, CAMERA_PLACE], 3)
    std = np.r_[camera_std, FREE_HEADING, offset_std or KNOWN_STD, [KNOWN_STD] * 4, wheel_std, frame]
    info = np.diag(std**-2)
    turn = slice(COMMON, COMMON + 3)
    info[turn, turn] = start.C_nb.T @ np.diag([FREE_TILT**-2, FREE_TILT**-2, FIXED**-2]) @ start.C_nb
    return state, Prior(Normal(info, np.zeros(COMMON + FRAME)), replace(state, bg=none, ba=none))


class VisualInertialWindow(InnerWindow):
    """An odometry source from tracks, calibrated IMU samples and fixes, from where an alignment begins.

    ``antenna`` may be set between two poses, as a graph learns of it.
    """

    def __init__(
        self, settings: VisionSettings, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes,
        start: AlignmentState, wheel: WheelAid | None = None,
    ) -> None:  # fmt: skip
        self.settings, self.tracks = settings, tracks
        seen, self._begin = tracks.frames()
        self.frames = keyframes(seen, start.t0, float(imu.t[-1]), FRAME_SPACING_S, MIN_FRAME_SPACING_S)
        wheel_std = KNOWN_STD if wheel is None else wheel.mount.scale_std
        begun = beginning(start, settings.camera, settings.site.noise, settings.offset_std, wheel_std)
        site, antenna = settings.site.shaken(ACCEL_NOISE_FACTOR, ACCEL_NOISE_FACTOR), settings.antenna
        super().__init__(site, settings.frames, ROUNDS, self.frames.t, imu, fixes, start, begun, antenna, wheel)
        self._scale = np.array([settings.camera.fx, settings.camera.fy]) / settings.camera.std
        self.rejected, self.seen_until = 0, -np.inf  # s, the newest keyframe that has a frame
        self._aided = bool(fixes.has_velocity.any())
        self._p_n = np.zeros(3)

    def poses(self) -> Iterator[OdometryPose]:
        """Yield a pose for each keyframe; none uses anything later."""
        for k, (t, at) in enumerate(zip(self.frames.t.tolist(), self.frames.at.tolist(), strict=True)):
            rows = slice(*self._begin[at : at + 2].tolist()) if at >= 0 else slice(0)
            frame = Frame(t, self.tracks.feature[rows], self.tracks.uv[rows])
            yield self._add(frame, self._recorded(k))

    def go_on(self, frame: Frame, imu: ImuSeries, fixes: GnssFixes) -> OdometryPose:
        """Return the pose of a new keyframe, behind those that `poses` has yielded; see `_live`."""
        self._aided = self._aided or bool(fixes.has_velocity.any())
        return self._add(frame, self._live(frame.t, imu, fixes))

    @property
    def times(self) -> FloatArray:
        """The times (k,) [s] of the keyframes."""
        back = np.cumsum([0.0, *(part.dt for part in reversed(self._held.parts))])
        return self.t - back[::-1]

    def see_late(self, frame: Frame) -> None:
        """Take a frame at one of `times` after `seen_until`; it counts from the next keyframe on."""
        at = int(np.argmin(np.abs(self.times - frame.t)))
        self.marks.see(at, frame.feature, self.settings.camera.rays(frame.uv))
        self.seen_until = frame.t

    @property
    def offset_std(self) -> float:
        """1 sigma of the camera's time offset [s]."""
        return DRIFT_FACTOR * float(np.sqrt(self.covariance(slice(OFFSET, OFFSET + 1))[0, 0]))

    def _add(self, frame: Frame, part: Preintegrated | None) -> OdometryPose:
        dt = frame.t - self.t
        self._add_keyframe(frame.t, part)
        self.marks.add_frame(frame.feature, self.settings.camera.rays(frame.uv))
        self.seen_until = frame.t if len(frame.feature) else self.seen_until
        self.marks.settle(self.state, self._scale)
        self._solve()
        self._reject()
        return self._pose(dt)

    def _reject(self) -> None:
        s = self.marks.sights
        ready = replace(s, seen=s.seen & self.marks.ready[:, None])
        rows, frames, r, y = residuals(self.state, ready, self._scale)
        bad = (np.linalg.norm(r, axis=1) > OUTLIER_SIGMAS) | (y[:, 2] <= 0)
        self.rejected += int(bad.sum())
        self.marks.reject(rows[bad], frames[bad])

    def _slide(self) -> BackSubstitution:
        dt = self._held.parts[0].dt
        self.marks.lose_unseen()
        gone = super()._slide()
        self._prior = walked(self._prior, HEADING, HEADING_WALK**2 * dt)
        if self.settings.offset_std:
            self._prior = walked(self._prior, OFFSET, OFFSET_WALK**2 * dt)
        return gone

    def _pose(self, dt: float) -> OdometryPose:
        """Return the newest pose in n: steps as the window has them now, turned by the heading as it is known."""
        R = self._heading()
        if len(self.state.p) > 1:
            self._p_n = self._p_n + R @ (self.state.p[-1] - self.state.p[-2])
        C_nb, drift = R @ self.state.C_ob[-1], self._drift(dt)
        if not self._aided:  # its frame is turned as the alignment had it; more the graph must find
            return OdometryPose(self.t, self._p_n, C_nb, drift, self.start.yaw_std)
        return OdometryPose(self.t, self._p_n, C_nb, drift, FRAME_STD, True, self._yaw_std())

    def _yaw_std(self) -> float:
        """Return 1 sigma [rad] of the newest keyframe's heading in n."""
        pick, last = np.zeros(self.state.size), self.last
        pick[HEADING], pick[last : last + 3] = 1.0, self.state.C_ob[-1][2]
        return DRIFT_FACTOR * float(np.sqrt(pick @ self._factor.solve(pick)))

    def _drift(self, dt: float) -> FloatArray:
        """Return the covariance (4, 4) of a step: that of the window from end to end, spread over its time."""
        last, first = self.last, COMMON
        if last == first:
            return np.eye(4) * 1e-8
        pick = np.zeros((self.state.size, 4))
        for at, sign, C in ((last, 1.0, self.state.C_ob[-1]), (first, -1.0, self.state.C_ob[0])):
            pick[at + 3 : at + 6, :3], pick[at : at + 3, 3] = sign * np.eye(3), sign * C[2]
        P = pick.T @ self._factor.solve(pick) * DRIFT_FACTOR**2 * dt / sum(part.dt for part in self._held.parts)
        P[3, :3], P[:3, 3] = 0.0, 0.0
        P[3, 3] = P[3, 3] if self._since > OUTAGE_S else FRAME_WALK**2 * dt
        return P
