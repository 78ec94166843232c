"""P3's inner layer: tracks, IMU and GNSS velocity in one window of ten keyframes (numpy, no gtsam).

Poses, velocities, biases, landmarks and where the camera sits are fitted together at each keyframe: reprojection
with Huber's loss, preintegration, the biases' walks, GNSS velocity, and a prior from what has left (P3 IV.A). The
landmarks are eliminated by hand, all at once in numpy: gtsam took 58 to 74 ms for such a window (FUSION.md 2), and
its fixed-lag smoother fails on landmarks that leave. What leaves is marginalised with all its sights; landmarks
that are still followed stay in the prior, so that nothing is used twice and nothing lost.

GNSS velocities between two keyframes are carried to the later one by the IMU.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries
from procedures.fusion.imu.gnss_velocity import LeverArm, velocities
from procedures.fusion.imu.inertial_increments import ImuGrid, grid
from procedures.fusion.imu.preintegration import Preintegrated, preintegrate
from procedures.fusion.inner.camera_keyframes import camera_keyframes
from procedures.fusion.inner.inertial_terms import Site, predicted
from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.inner.reprojection import residuals
from procedures.fusion.inner.window_problem import Factor, Held, Prior, assemble, marginalised, walked
from procedures.fusion.inner.window_state import COMMON, FRAME, HEADING, OFFSET, Normal, WindowState
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.outer.pose_graph_terms import rz
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera

FRAMES = 10
ROUNDS = 4
SMALL = 2e-2  # of a sigma, by which a last step may move
ASTRAY = 4.0  # whitened length of a sight (two axes) that is no match: 3e-4 by chance
CAMERA_TURN = np.radians(1.0)  # 1 sigma of what was given of the camera's place
CAMERA_PLACE = 0.02  # m
FREE_HEADING = 0.3  # rad on the first attitude: the alignment's own data are used again from there on
FREE_TILT = 0.1
FIXED = 1e-4  # rad, the heading of the window's own frame
FREE_VELOCITY = 1.0  # m/s
GIVEN = 1e-6  # s, of a camera's stamps
OFFSET_WALK = 3e-4  # s/sqrt(s): 50 ppm of a camera's own clock are 3 ms in a minute
ANCHOR = 1e-3  # m, the origin of an odometry
SHAKEN = 2.5  # what vibration, scale factors and misalignment make of an IMU's noise on a flight (EuRoC)
SLACK = 2.0  # of the drift that the window states: measured on real IMUs, docs/locate-vision.md
OUTAGE = 1.5  # s without a velocity from which the heading of the frame may drift
YAW = np.radians(0.05)  # rad: GNSS's velocities hold the odometry's frame to n
YAW_WALK = 1e-4  # rad/sqrt(s)


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
    start: AlignmentState, camera: PinholeCamera, noise: ImuNoise, offset_std: float = 0.0
) -> tuple[WindowState, Prior]:
    """Return the first keyframe, and the little that is known of it: its heading is the window's own."""
    none = np.zeros((1, 3))
    state = WindowState(
        start.C_nb[None], none, start.v_n[None], start.gyro_bias[None], start.accel_bias[None],
        camera.C_bc, camera.t_bc, 0.0, np.zeros((0, 3)), rate=none if offset_std else None,
    )  # fmt: skip
    frame = np.repeat([FREE_TILT, ANCHOR, FREE_VELOCITY, noise.gyro_bias, noise.accel_bias], 3)
    info = np.diag(
        np.r_[np.repeat([CAMERA_TURN, CAMERA_PLACE], 3), FREE_HEADING, offset_std or GIVEN, frame] ** -2
    )
    turn = slice(COMMON, COMMON + 3)
    info[turn, turn] = start.C_nb.T @ np.diag([FREE_TILT**-2, FREE_TILT**-2, FIXED**-2]) @ start.C_nb
    return state, Prior(Normal(info, np.zeros(COMMON + FRAME)), replace(state, bg=none, ba=none))


class VisualInertialWindow:
    """An odometry source from tracks, calibrated IMU samples and fixes, from where an alignment begins.

    ``antenna`` may be set between two poses, as a graph learns of it.
    """

    def __init__(
        self, settings: VisionSettings, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes,
        start: AlignmentState,
    ) -> None:  # fmt: skip
        self.settings, self.tracks, self.fixes, self.start = settings, tracks, fixes, start
        self.frames = camera_keyframes(tracks, imu, start.t0)
        self.marks = Landmarks()
        self.rejected = 0
        self._grid = grid(imu, self.frames.t)
        noise = settings.site.noise
        self._shaken = replace(noise, gyro=SHAKEN * noise.gyro, accel=SHAKEN * noise.accel)
        self.antenna = settings.antenna
        self._velocities = velocities(fixes, imu, start.gyro_bias)
        self._scale = np.array([settings.camera.fx, settings.camera.fy]) / settings.camera.std
        self.state, self._prior = beginning(start, settings.camera, settings.site.noise, settings.offset_std)
        self._held = Held([], np.zeros((1, 3)), np.zeros((1, 3)))
        self._aided = bool(np.isfinite(fixes.v_n[:, :2]).all(axis=1).any())
        self._p_n = np.zeros(3)
        self.t, self._since = start.t0, 0.0  # of the newest keyframe; s without a velocity

    def poses(self) -> Iterator[OdometryPose]:
        """Yield a pose for each keyframe; none uses anything later."""
        for k, rows in enumerate(self.frames.rows):
            part = self._between(self._grid, slice(*self._grid.at[k - 1 : k + 1].tolist())) if k else None
            yield self._add(float(self.frames.t[k]), part, self.tracks.feature[rows], self.tracks.uv[rows])

    @property
    def velocity(self) -> FloatArray:
        """The newest keyframe's velocity (3,) [m/s] in n."""
        v: FloatArray = self._heading() @ self.state.v[-1]
        return v

    @property
    def offset_std(self) -> float:
        """1 sigma of the camera's time offset [s]."""
        return SLACK * float(np.sqrt(self._factor.variance(OFFSET)))

    def _add(self, t: float, part: Preintegrated | None, feature: IntArray, uv: FloatArray) -> OdometryPose:
        """Add a keyframe at ``t`` [s] that saw ``feature`` (m,) at ``uv`` (m, 2) [px], and return its pose.

        ``part`` is the IMU since the keyframe before, None for the first.
        """
        if part is not None:
            self._go_on_by(part)
        self.marks.add_frame(feature, self.settings.camera.rays(uv))
        self.marks.settle(self.state, self._scale)
        self._solve()
        self._reject()
        dt, self.t = t - self.t, t
        self._since = 0.0 if self._held.weight[-1].any() else self._since + dt
        pose = self._pose(t, dt, self._since)
        if len(self.state.p) > self.settings.frames:
            self._slide()
        return pose

    def _go_on_by(self, part: Preintegrated) -> None:
        """Predict the next keyframe, and hold its velocity by GNSS's."""
        if self.state.rate is not None and len(self.state.p) == 1:
            self.state = replace(self.state, rate=part.rates[:1])
        self.state = self.state.with_frame(
            *predicted(self.state, part, self.settings.site), self.state.bg[-1], self.state.ba[-1], part.rates[-1]
        )
        C_nb, pull = self._heading() @ self.state.C_ob[-2], self.settings.site.pull(self.state.v[-2])
        v, weight = self._velocities.at_end(self.t, part, C_nb, pull, self.antenna)
        self._held = Held([*self._held.parts, part], np.vstack((self._held.v, v)),
                          np.vstack((self._held.weight, weight)))  # fmt: skip

    def _between(self, g: ImuGrid, rows: slice = slice(None)) -> Preintegrated:
        """Return some rows of the IMU on a grid, integrated from the newest keyframe on."""
        site, state = self.settings.site, self.state
        part = ImuGrid(g.dt[rows], g.omega_b[rows], g.f_b[rows], g.at[:0])
        return preintegrate(part, state.bg[-1], state.ba[-1], state.C_ob[-1].T @ site.earth_n, self._shaken)

    def _solve(self) -> None:
        for _ in range(ROUNDS):
            normal, free = assemble(
                self.state, self._prior, self._held, self.settings.site, self.marks,
                self.marks.sights.seen, self._scale,
            )  # fmt: skip
            self._factor = Factor(normal.A)
            step = -self._factor.solve(normal.g)
            self.state = self.state.moved(step)
            self.marks.step(free.rows, free.step(step), self.state.held)
            if step @ normal.A @ step < SMALL**2 * len(step):
                break

    def _reject(self) -> None:
        s = self.marks.sights
        ready = replace(s, seen=s.seen & self.marks.ready[:, None])
        rows, frames, r, y = residuals(self.state, ready, self._scale)
        bad = (np.linalg.norm(r, axis=1) > ASTRAY) | (y[:, 2] <= 0)
        self.rejected += int(bad.sum())
        self.marks.reject(rows[bad], frames[bad])

    def _slide(self) -> None:
        self._prior = marginalised(
            self.state, self._prior, self._held, self.settings.site, self.marks, self._scale
        )
        self.state = replace(self.state.without_first(), held=self._prior.at.held)
        h = self._held
        if self.settings.offset_std:
            known = walked(self._prior.normal, OFFSET, OFFSET_WALK**2 * h.parts[0].dt)
            self._prior = replace(self._prior, normal=known)
        self._held = Held(h.parts[1:], h.v[1:], h.weight[1:])

    def _heading(self) -> FloatArray:
        return rz(np.array(self.state.heading))[0]

    def _pose(self, t: float, dt: float, since: float) -> OdometryPose:
        """Return the newest pose in n: steps as the window has them, turned by the heading as it is known then.

        A step is that from the keyframe before as both are known now. Were it from where that was thought to be, a
        window that learns that it has come elsewhere would have moved: by 20 m where a camera joined an IMU whose
        height nothing had held for half a minute.
        """
        R = self._heading()
        if len(self.state.p) > 1:
            self._p_n = self._p_n + R @ (self.state.p[-1] - self.state.p[-2])
        C_nb, drift = R @ self.state.C_ob[-1], self._drift(dt, since)
        if not self._aided:  # its frame is turned as the alignment had it; more the graph must find
            return OdometryPose(t, self._p_n, C_nb, drift, self.start.yaw_std)
        return OdometryPose(t, self._p_n, C_nb, drift, YAW, uses_velocity=True, own_yaw_std=self._yaw_std())

    def _yaw_std(self) -> float:
        """Return 1 sigma [rad] of the newest keyframe's heading in n."""
        pick, last = np.zeros(self.state.size), self.state.frame(len(self.state.p) - 1).start
        pick[HEADING], pick[last : last + 3] = 1.0, self.state.C_ob[-1][2]
        return SLACK * float(np.sqrt(pick @ self._factor.solve(pick)))

    def _drift(self, dt: float, since: float) -> FloatArray:
        """Return the covariance (4, 4) of a step: that of the window from end to end, spread over its time."""
        last, first = self.state.frame(len(self.state.p) - 1).start, self.state.frame(0).start
        if last == first:
            return np.eye(4) * 1e-8
        pick = np.zeros((self.state.size, 4))
        pick[last + 3 : last + 6, :3], pick[first + 3 : first + 6, :3] = np.eye(3), -np.eye(3)
        pick[last : last + 3, 3], pick[first : first + 3, 3] = self.state.C_ob[-1][2], -self.state.C_ob[0][2]
        P = pick.T @ self._factor.solve(pick) * SLACK**2 * dt / sum(part.dt for part in self._held.parts)
        P[3, :3], P[:3, 3] = 0.0, 0.0
        P[3, 3] = P[3, 3] if since > OUTAGE else YAW_WALK**2 * dt
        drift: FloatArray = P
        return drift
