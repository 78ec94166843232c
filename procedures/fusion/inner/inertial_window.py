"""The inner layer without a camera: IMU and GNSS velocity, and with ``layers`` 1 GNSS position.

A fix's velocity holds the velocity, or standing still does; a receiver without vertical velocity holds it by its
height. No Huber, for what has left cannot be weighted again: outliers are the outer layer's. Without position the
window is an odometry in n: its displacements are GNSS's velocities summed up, and drift by their white noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment_in_motion import ACCEL_NOISE_FACTOR
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries
from procedures.fusion.gnss_velocity import GnssMeasurements, KeyframeFix, LeverArm, no_fix
from procedures.fusion.inner.inner_window import (
    FRAME_STD,
    FRAME_WALK,
    FREE_VELOCITY,
    KNOWN_STD,
    ORIGIN_STD,
    OUTAGE_S,
    InnerWindow,
)
from procedures.fusion.inner.marginalised_keyframes import MarginalisedKeyframe, RevisedPath, smoothed_states
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.inner.window_problem import BackSubstitution, Prior, WindowMeasurements, marginalised
from procedures.fusion.inner.window_state import ANTENNA, KEYFRAME_SPACING_S, SPEED, Normal, WindowState, keyframes
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.odometry import AntennaEstimate, OdometryPose
from procedures.fusion.preintegration import Preintegrated

FREE_TURN = 0.3  # rad on the first attitude: the alignment's own data are used again from there on
FREE_POSITION = 10.0  # m
HEIGHT_TIME = 1.0  # s, for which the error of a height lasts that is held by GNSS's


@dataclass(frozen=True, slots=True, eq=False)
class WindowSettings:
    """``lever`` (3,) [m] in b from IMU to antenna, ``spacing`` [s] of keyframes, ``frames`` of them in the window.

    ``still_std`` [m/s]: the IMU is known to stand, and by how much; GNSS velocities are then not used.
    ``lever_std`` [m] and ``offset_std`` [s]: lever arm, and the time offset that the fixes' stamps still lack,
    are estimated from ``lever`` and 0 on where either is given.
    """

    site: Site
    lever: FloatArray
    layers: int = 2
    frames: int = 20
    spacing: float = KEYFRAME_SPACING_S
    still_std: float | None = None
    lever_std: float | None = None
    offset_std: float | None = None


class InertialWindow(InnerWindow):
    """An odometry source from calibrated IMU samples and fixes, from where an alignment begins.

    ``covariance_n`` (4, 4) is that of the newest position [m] and heading [rad] in n.
    """

    def __init__(
        self, settings: WindowSettings, imu: ImuSeries, fixes: GnssFixes, start: AlignmentState,
        wheel: WheelAid | None = None,
    ) -> None:  # fmt: skip
        self.settings = settings
        self.frames = keyframes(fixes.t, start.t0, float(imu.t[-1]), settings.spacing)
        self._is_flat = settings.still_std is None and not np.isfinite(fixes.v_n[:, 2]).any()
        begun = self._beginning(fixes, start, KNOWN_STD if wheel is None else wheel.mount.scale_std)
        site = settings.site.shaken(1.0, ACCEL_NOISE_FACTOR if settings.still_std is None else 1.0)
        antenna = LeverArm(settings.lever)
        super().__init__(site, settings.frames, 1, self.frames.t, imu, fixes, start, begun, antenna, wheel)
        self._first, self._left = begun[1], list[MarginalisedKeyframe]()
        self._is_settled = False  # that it was linearised again where the alignment's data end
        self._path = RevisedPath()

    def poses(self) -> Iterator[OdometryPose]:
        """Yield a pose for each keyframe; none uses anything later."""
        for k, t in enumerate(self.frames.t.tolist()):
            yield self._add(t, self._recorded(k))

    def go_on(self, t: float, imu: ImuSeries, fixes: GnssFixes) -> OdometryPose:
        """Return the pose of a new keyframe at ``t`` [s], behind those that `poses` has yielded; see `_live`."""
        if self._is_settled:
            self._left = []  # for no smoothed one
        return self._add(t, self._live(t, imu, fixes))

    @property
    def constants(self) -> FloatArray:
        """Lever arm [m] and time offset [s] (4,), as they are known now."""
        constants: FloatArray = np.r_[self.settings.lever, 0.0] + self.state.antenna
        return constants

    def smoothed(self) -> list[tuple[float, FloatArray, FloatArray]]:
        """Return time [s], position (3,) [m] and attitude (3, 3) of each keyframe by all fixes, and end.

        Source of the smoothing: Rauch, Tung, Striebel 1965.
        """
        self._linearise_again()
        states, times = smoothed_states(self._left, self.state), self.frames.t.tolist()
        return [(t, state.p[0], state.C_ob[0]) for t, state in zip(times, states, strict=True)]

    def _linearise_again(self) -> None:
        """Eliminate all keyframes but the newest again, linearised where they stand by all that was measured."""
        while len(self.state.p) > 1:
            self._slide()
        states = smoothed_states(self._left, self.state)
        prior, left = self._first, list[MarginalisedKeyframe]()
        for here, there, one in zip(states[:-1], states[1:], self._left, strict=True):
            two = here.with_frame(there.C_ob[0], there.p[0], there.v[0], there.bg[0], there.ba[0])
            prior, gone = marginalised(two, prior, one.held, self.settings.site, self.marks, self._scale)
            left.append(MarginalisedKeyframe(two, one.held, gone))
        self._prior, self._left = prior, left
        self._solve()

    def _beginning(self, fixes: GnssFixes, start: AlignmentState, wheel_std: float) -> tuple[WindowState, Prior]:
        """Return the first keyframe, and the little that is known of it."""
        settings, noise, first = self.settings, self.settings.site.noise, max(int(self.frames.at[0]), 0)
        none, p = np.zeros((1, 3)), fixes.p_n[first] - start.C_nb @ settings.lever
        state = WindowState(
            start.C_nb[None], p[None], start.v_n[None], start.gyro_bias[None], start.accel_bias[None],
            np.eye(3), np.zeros(3), 0.0, np.zeros((0, 3)),
        )  # fmt: skip
        where = np.full(3, FREE_POSITION if settings.layers == 1 else ORIGIN_STD)
        if settings.still_std is None and not np.isfinite(fixes.v_n[first, 2]):
            where[2] = FREE_POSITION
        frame = np.repeat([FREE_TURN, FREE_VELOCITY, noise.gyro_bias, noise.accel_bias], 3)
        antenna = np.r_[np.full(3, settings.lever_std or KNOWN_STD), settings.offset_std or KNOWN_STD]
        std = np.r_[np.full(ANTENNA.start, KNOWN_STD), antenna, wheel_std, frame[:3], where, frame[3:]]
        return state, Prior(Normal(np.diag(std**-2), np.zeros(len(std))), replace(state, bg=none, ba=none))

    def _measurements(self, fixes: GnssFixes, imu: ImuSeries) -> GnssMeasurements:
        """Return velocities that are whole, level at least, and the positions that are to hold something."""
        measured = super()._measurements(fixes, imu)
        unclimbed, v_std = ~np.isfinite(fixes.v_n[:, 2]), measured.v_std.copy()
        v_std[~fixes.has_velocity], v_std[unclimbed, 2] = np.inf, np.inf
        p_std = np.repeat(fixes.position_std[:, None], 3, axis=1)
        if self.settings.layers == 2:
            p_std[:, :2], p_std[~unclimbed, 2] = np.inf, np.inf
        return replace(measured, v_std=v_std, p_std=p_std)

    def _fix(self, part: Preintegrated, C_nb: FloatArray, pull: FloatArray) -> KeyframeFix:
        if self.settings.still_std is not None:
            return replace(no_fix(), v_weight=np.full(3, self.settings.still_std**-2.0))
        return super()._fix(part, C_nb, pull)

    def _add(self, t: float, part: Preintegrated | None) -> OdometryPose:
        dt = t - self.t
        self._add_keyframe(t, part)
        self._solve()
        if not self._is_settled and t >= self.start.t:
            self._linearise_again()
            self._is_settled = True
        return self._pose(dt)

    def _slide(self) -> BackSubstitution:
        two, held = self.state.part(slice(2)), WindowMeasurements(self._held.parts[:1], self._held.fixes[:1])
        left = MarginalisedKeyframe(two, held, super()._slide())
        if self.settings.layers == 1 or not self._is_settled:
            self._left.append(left)
        if self.settings.layers == 2:
            self._path.slid(left)
        return left.gone

    def _pose(self, dt: float) -> OdometryPose:
        """Return the newest pose, ``dt`` [s] after the one before."""
        C_nb, p = self.state.C_ob[-1], self.state.p[-1]
        pick = np.zeros((6, 4))
        pick[3:, :3], pick[:3, 3] = np.eye(3), C_nb[2]
        self.covariance_n = P = pick.T @ self.covariance(slice(self.last, self.last + 6)) @ pick
        drift = self._drift(dt)
        if self._is_flat:  # its height is held, and errs for a while and back
            drift[2, 2] += 2 * P[2, 2] * dt / HEIGHT_TIME
        own_yaw_std = float(np.sqrt(P[3, 3]))
        pose = OdometryPose(self.t, p, C_nb, drift, FRAME_STD, True, own_yaw_std, self._antenna())
        return pose if self.settings.layers == 1 else self._handed_on(pose)

    def _handed_on(self, pose: OdometryPose) -> OdometryPose:
        """Return the newest pose at the end of the revised path, with the poses that have changed."""
        path, has_velocity = self._path, self._since == 0.0
        looks_back = path.listen(has_velocity, self._since > OUTAGE_S and self._is_settled)
        revised = tuple[OdometryPose, ...]()
        if has_velocity or looks_back or self._held.fixes[-1].wheel is not None:  # else all stands where it stood
            revised = path.revise(self.state, self._factor, self._velocity_density(), looks_back)
        pose = replace(pose, p_o=path.newest(self.state), revised=revised, open_since=path.open_since)
        path.add(replace(pose, revised=()))
        return pose

    def _antenna(self) -> AntennaEstimate | None:
        if self.settings.lever_std is None and self.settings.offset_std is None:
            return None
        return AntennaEstimate(self.constants[:3], self.covariance(ANTENNA), float(self.constants[3]))

    def _drift(self, dt: float) -> FloatArray:
        """Return the covariance (4, 4) of a step: velocity noise summed up, or an outage's velocity error."""
        if self._since > OUTAGE_S or self.settings.layers == 1:
            speed = slice(self.last + SPEED.start, self.last + SPEED.stop)
            moved = 2 * np.diag(self.covariance(speed)) * self._since * dt
        else:
            moved = np.full(3, self._velocity_density() * max(dt, 1e-6))
        return np.diag(np.r_[moved, max(FRAME_WALK**2 * dt, 1e-16)])

    def _velocity_density(self) -> float:
        """Return the density [m2/s] of displacements by summed velocities: their variance times their spacing."""
        if self.settings.still_std is not None:
            return self.settings.still_std**2 * self.settings.spacing
        i = int(np.searchsorted(self.fixes.t, self.t, "right")) - 1
        i = min(max(i, 1), len(self.fixes.t) - 1)
        std = np.nanmin(self.fixes.velocity_std[max(i - 5, 0) : i + 1])
        return float(std**2 * min(self.fixes.t[i] - self.fixes.t[i - 1], OUTAGE_S))
