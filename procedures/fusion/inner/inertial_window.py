"""The inner layer without a camera: IMU and GNSS velocity in one fixed-lag window of factors (gtsam).

Keyframes are tied by combined IMU factors: preintegration with the biases' random walks (Forster, Carlone,
Dellaert, Scaramuzza 2017) and the exact rotation of the Earth, which a FOG sees. A fix's velocity holds the
velocity, or standing still does; a receiver without vertical velocity holds it by its height. With ``layers`` 1 a
fix's position stands in the same window. What leaves the window is marginalised. QR, for Cholesky fails on these
factors; no Huber, for inside an incremental window it locks good fixes out after a poor start: outliers are the
outer layer's.

Without position the window is an odometry in n: its displacements are GNSS's velocities summed up, and drift by
their white noise. Where velocities are missing it drifts by the velocity's own sigma.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment.alignment_in_motion import ACCEL_NOISE_FACTOR
from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries
from procedures.fusion.inner.fix_factors import FixFactors
from procedures.fusion.inner.imu_factors import Preintegration
from procedures.fusion.inner.keyframes import SPACING, keyframes
from procedures.fusion.odometry import AntennaEstimate, OdometryPose
from procedures.fusion.optional_libraries import gtsam

FREE_TURN = 0.3  # rad on the first attitude: the alignment's own data are used again from there on
FREE_VELOCITY = 1.0  # m/s
FREE_POSITION = 10.0  # m
ANCHOR = 1e-3  # m, the origin of an odometry
UNKNOWN = 1e4  # m or m/s, of a component that is not measured
GIVEN = 1e-6  # m or s, of a constant that is not estimated beside one that is
HEIGHT_TIME = 1.0  # s, for which the error of a height lasts that is held by GNSS's
OUTAGE = 1.5  # s without a velocity from which its sigma is asked for
FRAME = np.radians(0.05)  # rad: GNSS's velocities hold the odometry's frame to n
FRAME_WALK = 1e-4  # rad/sqrt(s)


@dataclass(frozen=True, slots=True, eq=False)
class WindowSettings:
    """``gravity`` [m/s2], ``earth_n`` (3,) [rad/s], ``lever`` (3,) [m] in b, ``lag`` and ``spacing`` [s].

    ``still_std`` [m/s]: the IMU is known to stand, and by how much; GNSS velocities are then left out.
    ``lever_std`` [m] and ``offset_std`` [s]: lever arm, and the time offset that the fixes' stamps still lack,
    are estimated from ``lever`` and 0 on where either is given.
    """

    noise: ImuNoise
    gravity: float
    earth_n: FloatArray
    lever: FloatArray
    layers: int = 2
    lag: float = 2.0
    spacing: float = SPACING
    still_std: float | None = None
    lever_std: float | None = None
    offset_std: float | None = None

    @property
    def estimates(self) -> bool:
        """Whether lever arm or time offset are estimated."""
        return self.lever_std is not None or self.offset_std is not None


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """A keyframe as it was known then: ``C_nb`` (3, 3), ``p`` [m], ``v`` [m/s], biases [rad/s], [m/s2]."""

    t: float
    C_nb: FloatArray
    p: FloatArray
    v: FloatArray
    gyro_bias: FloatArray
    accel_bias: FloatArray
    has_velocity: bool


class InertialWindow:
    """An odometry source from calibrated IMU samples and fixes, from where an alignment begins."""

    def __init__(self, settings: WindowSettings, imu: ImuSeries, fixes: GnssFixes, start: AlignmentState) -> None:
        self.settings, self.fixes, self.start = settings, fixes, start
        self.frames = keyframes(fixes, imu, start.t0, settings.spacing)
        self._lib = gtsam()
        self.constants = np.r_[settings.lever, 0.0]  # lever arm [m], time offset [s], as they are known now
        shaken = ACCEL_NOISE_FACTOR if settings.still_std is None else 1.0
        self._imu = Preintegration(
            self._lib, replace(settings.noise, accel=shaken * settings.noise.accel), settings.gravity,
            settings.earth_n, imu, self.frames.t,
        )  # fmt: skip
        self.state: State | None = None
        self._is_flat = settings.still_std is None and not np.isfinite(fixes.v_n[:, 2]).any()
        self.factors, self.values = (
            self._lib.NonlinearFactorGraph(),
            self._lib.Values(),
        )  # all, for the smoothed one

    def poses(self) -> Iterator[OdometryPose]:
        """Yield a pose for each keyframe; none uses anything later."""
        before, since = self.frames.t[0], 0.0
        for state in self.states():
            dt = state.t - before
            before, since = state.t, 0.0 if state.has_velocity else since + dt
            yield self._pose(state, dt, since)

    def states(self) -> Iterator[State]:
        """Yield what is known at each keyframe, then."""
        self._smoother = self._lib.IncrementalFixedLagSmoother(self.settings.lag, _isam(self._lib))
        self.state = self._first()
        for k in range(len(self.frames.t)):
            self.state = self._advanced(k, self.state)
            yield self.state

    def covariance(self) -> FloatArray:
        """Return the covariance (6, 6) of the newest pose: rotation in b [rad], position in n [m]."""
        C = np.asarray(self._smoother.marginalCovariance(self._key("x")))
        T = np.eye(6)
        assert self.state is not None
        T[3:, 3:] = self.state.C_nb  # gtsam moves a pose in its own axes
        return np.asarray(T @ C @ T.T)

    def global_covariance(self) -> FloatArray:
        """Return the covariance (4, 4) of the newest position [m] and heading [rad] in n."""
        assert self.state is not None
        J = np.zeros((4, 6))
        J[:3, 3:], J[3, :3] = np.eye(3), self.state.C_nb[2]
        covariance: FloatArray = J @ self.covariance() @ J.T
        return covariance

    def bias_covariance(self) -> FloatArray:
        """Return the covariance (6, 6) of the newest biases: accelerometer [m/s2], gyro [rad/s]."""
        return np.asarray(self._smoother.marginalCovariance(self._key("b")))

    def smoothed(self) -> list[tuple[float, FloatArray, FloatArray]]:
        """Return time, position and attitude of every keyframe by all factors, outliers included."""
        lib = self._lib
        params = lib.LevenbergMarquardtParams()
        params.setLinearSolverType("MULTIFRONTAL_QR")
        found = lib.LevenbergMarquardtOptimizer(self.factors, self.values, params).optimize()
        poses = [found.atPose3(lib.symbol("x", k)) for k in range(len(self.frames.t))]
        return [
            (float(t), np.asarray(pose.translation()), np.asarray(pose.rotation().matrix()))
            for t, pose in zip(self.frames.t, poses, strict=True)
        ]

    def _key(self, letter: str, k: int | None = None) -> int:
        return int(self._lib.symbol(letter, self._k if k is None else k))

    def _first(self) -> State:
        fix = max(int(self.frames.fix[0]), 0)
        s = self.start
        p = self.fixes.p_n[fix] - s.C_nb @ self.settings.lever
        return State(float(self.frames.t[0]), s.C_nb, p, s.v_n, s.gyro_bias, s.accel_bias, has_velocity=True)

    def _advanced(self, k: int, last: State) -> State:
        """Add keyframe k with its factors and return what is known of it then."""
        lib, self._k = self._lib, k
        factors, values = lib.NonlinearFactorGraph(), lib.Values()
        pose, velocity, bias = _to_gtsam(lib, last)
        if k == 0:
            self._add_priors(factors, last, pose)
        else:
            whole = self._imu.until(k, bias)
            keys = [self._key(letter, at) for letter, at in (("x", k - 1), ("v", k - 1), ("x", k), ("v", k))]
            factors.push_back(lib.CombinedImuFactor(*keys, self._key("b", k - 1), self._key("b", k), whole))
            predicted = whole.predict(lib.NavState(pose, velocity), bias)
            pose, velocity = predicted.pose(), predicted.velocity()
        has_velocity = self._add_fix(factors, k, np.asarray(pose.rotation().matrix()), last)
        values.insert(self._key("x"), pose)
        values.insert(self._key("v"), velocity)
        values.insert(self._key("b"), bias)
        t = float(self.frames.t[k])
        stamps = dict.fromkeys((self._key("x"), self._key("v"), self._key("b")), t)
        if self.settings.estimates:
            stamps[self._key("c", 0)] = t  # it never leaves the window
            if k == 0:
                values.insert(self._key("c", 0), self.constants)
        self._smoother.update(factors, values, stamps)
        return self._estimate(t, has_velocity, factors)

    def _estimate(self, t: float, has_velocity: bool, factors: Any) -> State:
        pose = self._smoother.calculateEstimatePose3(self._key("x"))
        velocity = self._smoother.calculateEstimateVector(self._key("v"))
        bias = self._smoother.calculateEstimateConstantBias(self._key("b"))
        self.factors.push_back(factors)
        if self.settings.estimates:
            self.constants = np.asarray(self._smoother.calculateEstimateVector(self._key("c", 0)))
            self.values.insert_or_assign(self._key("c", 0), self.constants)
        for letter, value in (("x", pose), ("v", velocity), ("b", bias)):
            self.values.insert(self._key(letter), value)
        return State(
            t, np.asarray(pose.rotation().matrix()), np.asarray(pose.translation()), np.asarray(velocity),
            np.asarray(bias.gyroscope()), np.asarray(bias.accelerometer()), has_velocity,
        )  # fmt: skip

    def _add_priors(self, factors: Any, first: State, pose: Any) -> None:
        lib, noise = self._lib, self.settings.noise
        where = np.full(3, FREE_POSITION if self.settings.layers == 1 else ANCHOR)
        where[2] = FREE_POSITION if self._height_holds(max(int(self.frames.fix[0]), 0)) else where[2]
        turn = np.full(3, FREE_TURN)
        b_std = np.r_[np.full(3, noise.accel_bias), np.full(3, noise.gyro_bias)]
        sigmas = lib.noiseModel.Diagonal.Sigmas
        where_b = np.sqrt(np.diag(first.C_nb.T @ np.diag(where**2) @ first.C_nb))
        factors.push_back(lib.PriorFactorPose3(self._key("x"), pose, sigmas(np.r_[turn, where_b])))
        factors.push_back(lib.PriorFactorVector(self._key("v"), first.v, sigmas(np.full(3, FREE_VELOCITY))))
        factors.push_back(lib.PriorFactorConstantBias(self._key("b"), lib.imuBias.ConstantBias(), sigmas(b_std)))
        if self.settings.estimates:
            c_std = np.r_[np.full(3, self.settings.lever_std or GIVEN), self.settings.offset_std or GIVEN]
            factors.push_back(lib.PriorFactorVector(self._key("c", 0), self.constants, sigmas(c_std)))

    def _add_fix(self, factors: Any, k: int, C_nb: FloatArray, last: State) -> bool:
        """Add what a fix says of keyframe k; return whether its velocity is held."""
        i, still = int(self.frames.fix[k]), self.settings.still_std
        if still is not None:
            at_rest = self._lib.noiseModel.Diagonal.Sigmas(np.full(3, still))
            factors.push_back(self._lib.PriorFactorVector(self._key("v"), np.zeros(3), at_rest))
            return True
        if i < 0:
            return False
        says = self._fix(i)
        keys = [self._key("x"), self._key("v"), self._key("c", 0)]
        rate = self._imu.rate[k] - last.gyro_bias
        if self.settings.estimates:
            made = says.with_constants(self._lib, keys, rate, self._imu.acceleration(k, C_nb, last.accel_bias))
        else:
            made = says.as_given(self._lib, keys, C_nb @ np.cross(rate, self.settings.lever), self.settings.lever)
        for factor in made:
            factors.push_back(factor)
        return says.v is not None

    def _fix(self, i: int) -> FixFactors:
        """Return what fix i says here: components that are not to be used are unknown."""
        v, p_std = self.fixes.v_n[i], np.full(3, self.fixes.position_std[i])
        v_std = np.where(np.isfinite(v), self.fixes.velocity_std[i], UNKNOWN)
        if self.settings.layers == 2:
            p_std[:2] = UNKNOWN
        p = self.fixes.p_n[i] if self.settings.layers == 1 or self._height_holds(i) else None
        return FixFactors(np.nan_to_num(v) if np.isfinite(v[:2]).all() else None, v_std, p, p_std)

    def _height_holds(self, i: int) -> bool:
        return not np.isfinite(self.fixes.v_n[i, 2]) and self.settings.still_std is None

    def _pose(self, state: State, dt: float, since: float) -> OdometryPose:
        """Return a keyframe as a pose: ``dt`` [s] after the one before, ``since`` [s] without a velocity."""
        P = self.global_covariance()
        drift = self._drift(dt, since)
        if self._is_flat:  # its height is held, and errs for a while and back
            drift[2, 2] += 2 * P[2, 2] * dt / HEIGHT_TIME
        own = float(np.sqrt(P[3, 3]))
        return OdometryPose(state.t, state.p, state.C_nb, drift, FRAME, True, own, self._antenna())

    def _antenna(self) -> AntennaEstimate | None:
        if not self.settings.estimates:
            return None
        P = np.asarray(self._smoother.marginalCovariance(self._key("c", 0)))
        return AntennaEstimate(self.constants[:3], P, float(self.constants[3]))

    def _drift(self, dt: float, since: float) -> FloatArray:
        """Return the covariance (4, 4) of a step: velocity noise summed up, or no velocity for ``since`` [s]."""
        if since > OUTAGE:
            P = np.asarray(self._smoother.marginalCovariance(self._key("v")))
            moved = 2 * np.diag(P) * since * dt
        else:
            rate = self._velocity_density()
            moved = np.full(3, rate * max(dt, 1e-6))
        return np.diag(np.r_[moved, max(FRAME_WALK**2 * dt, 1e-16)])

    def _velocity_density(self) -> float:
        """Return the density [m2/s] of displacements by summed velocities: their variance times their spacing."""
        if self.settings.still_std is not None:
            return self.settings.still_std**2 * self.settings.spacing
        i = int(np.searchsorted(self.fixes.t, self.frames.t[self._k]))
        i = min(max(i, 1), len(self.fixes.t) - 1)
        std = np.nanmin(self.fixes.velocity_std[max(i - 5, 0) : i + 1])
        return float(std**2 * min(self.fixes.t[i] - self.fixes.t[i - 1], OUTAGE))


def _isam(lib: Any) -> Any:
    params = lib.ISAM2Params()
    params.setFactorization("QR")
    params.setRelinearizeThreshold(0.01)
    params.relinearizeSkip = 1
    params.findUnusedFactorSlots = True
    return params


def _to_gtsam(lib: Any, state: State) -> tuple[Any, Any, Any]:
    pose = lib.Pose3(lib.Rot3(state.C_nb), state.p)
    return pose, state.v, lib.imuBias.ConstantBias(state.accel_bias, state.gyro_bias)
