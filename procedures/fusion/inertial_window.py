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
from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment import Aligned
from procedures.fusion.extra import gtsam
from procedures.fusion.imu_gaps import ImuGap, imu_gaps
from procedures.fusion.inertial_increments import grid
from procedures.fusion.keyframes import SPACING, keyframes
from procedures.fusion.moving_aligner import SHAKEN
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.records import GnssFixes, ImuNoise, ImuSeries

INTEGRATION = 1e-8  # m2/s, error of integrating the position
FREE_TURN = 0.3  # rad on the first attitude: the alignment's own data are used again from there on
FREE_VELOCITY = 1.0  # m/s
FREE_POSITION = 10.0  # m
ANCHOR = 1e-3  # m, the origin of an odometry
UNKNOWN = 1e4  # m or m/s, of a component that is not measured
OUTAGE = 1.5  # s without a velocity from which its sigma is asked for
FRAME = np.radians(0.05)  # rad: GNSS's velocities hold the odometry's frame to n
FRAME_WALK = 1e-4  # rad/sqrt(s)


@dataclass(frozen=True, slots=True, eq=False)
class WindowSettings:
    """``gravity`` [m/s2], ``earth_n`` (3,) [rad/s], ``lever`` (3,) [m] in b, ``lag`` and ``spacing`` [s].

    ``still_std`` [m/s]: the IMU is known to stand, and by how much; GNSS velocities are then left out.
    ``lever_std`` [m]: 1 sigma of the lever arm at the start; it widens velocities by how fast the IMU turns.
    """

    noise: ImuNoise
    gravity: float
    earth_n: FloatArray
    lever: FloatArray
    layers: int = 2
    lag: float = 2.0
    spacing: float = SPACING
    still_std: float | None = None
    lever_std: float = 0.0


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

    def __init__(self, settings: WindowSettings, imu: ImuSeries, fixes: GnssFixes, start: Aligned) -> None:
        self.settings, self.fixes, self.start = settings, fixes, start
        self.frames = keyframes(fixes, imu, start.t0, settings.spacing)
        self._grid = grid(imu, self.frames.t)
        self._rate = np.stack([np.interp(self.frames.t, imu.t, imu.omega_b[:, i]) for i in range(3)], axis=1)
        self.lever, self.lever_std = settings.lever, settings.lever_std
        self._lib = gtsam()
        self._params = self._preintegration()
        self._gaps = [(gap, self._preintegration(gap)) for gap in imu_gaps(imu)]
        self.state: State | None = None
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
            own = float(np.sqrt(self.global_covariance()[3, 3]))
            yield OdometryPose(state.t, state.p, state.C_nb, self._drift(dt, since), FRAME, True, own)

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

    def _preintegration(self, gap: ImuGap | None = None) -> Any:
        noise, eye = self.settings.noise, np.eye(3)
        shaken = SHAKEN if self.settings.still_std is None else 1.0
        gyro, accel = noise.gyro**2, (shaken * noise.accel) ** 2
        if gap is not None:  # a density that has made as much of it at its end
            gyro, accel = gyro + gap.rate_std**2 * gap.length, accel + gap.force_std**2 * gap.length
        params = self._lib.PreintegrationCombinedParams(np.array([0.0, 0.0, -self.settings.gravity]))
        params.setGyroscopeCovariance(gyro * eye)
        params.setAccelerometerCovariance(accel * eye)
        params.setBiasOmegaCovariance(noise.gyro_walk**2 * eye)
        params.setBiasAccCovariance(noise.accel_walk**2 * eye)
        params.setIntegrationCovariance(INTEGRATION * eye)
        params.setOmegaCoriolis(self.settings.earth_n)
        return params

    def _first(self) -> State:
        fix = max(int(self.frames.fix[0]), 0)
        s = self.start
        p = self.fixes.p_n[fix] - s.C_nb @ self.lever
        return State(float(self.frames.t[0]), s.C_nb, p, s.v_n, s.gyro_bias, s.accel_bias, has_velocity=True)

    def _advanced(self, k: int, last: State) -> State:
        """Add keyframe k with its factors and return what is known of it then."""
        lib, self._k = self._lib, k
        factors, values = lib.NonlinearFactorGraph(), lib.Values()
        pose, velocity, bias = _to_gtsam(lib, last)
        if k == 0:
            self._add_priors(factors, last, pose)
        else:
            whole = self._preintegrated(k, bias)
            keys = [self._key(letter, at) for letter, at in (("x", k - 1), ("v", k - 1), ("x", k), ("v", k))]
            factors.push_back(lib.CombinedImuFactor(*keys, self._key("b", k - 1), self._key("b", k), whole))
            predicted = whole.predict(lib.NavState(pose, velocity), bias)
            pose, velocity = predicted.pose(), predicted.velocity()
        has_velocity = self._add_fix(factors, k, np.asarray(pose.rotation().matrix()), last.gyro_bias)
        values.insert(self._key("x"), pose)
        values.insert(self._key("v"), velocity)
        values.insert(self._key("b"), bias)
        t = float(self.frames.t[k])
        self._smoother.update(factors, values, dict.fromkeys((self._key("x"), self._key("v"), self._key("b")), t))
        return self._estimate(t, has_velocity, factors)

    def _estimate(self, t: float, has_velocity: bool, factors: Any) -> State:
        pose = self._smoother.calculateEstimatePose3(self._key("x"))
        velocity = self._smoother.calculateEstimateVector(self._key("v"))
        bias = self._smoother.calculateEstimateConstantBias(self._key("b"))
        self.factors.push_back(factors)
        for letter, value in (("x", pose), ("v", velocity), ("b", bias)):
            self.values.insert(self._key(letter), value)
        return State(
            t, np.asarray(pose.rotation().matrix()), np.asarray(pose.translation()), np.asarray(velocity),
            np.asarray(bias.gyroscope()), np.asarray(bias.accelerometer()), has_velocity,
        )  # fmt: skip

    def _preintegrated(self, k: int, bias: Any) -> Any:
        middle = (self.frames.t[k - 1] + self.frames.t[k]) / 2
        params = next((each for gap, each in self._gaps if gap.first < middle < gap.last), self._params)
        whole = self._lib.PreintegratedCombinedMeasurements(params, bias)
        for i in range(int(self._grid.at[k - 1]), int(self._grid.at[k])):
            whole.integrateMeasurement(self._grid.f_b[i], self._grid.omega_b[i], self._grid.dt[i])
        return whole

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

    def _add_fix(self, factors: Any, k: int, C_nb: FloatArray, gyro_bias: FloatArray) -> bool:
        """Add what a fix says of keyframe k; return whether its velocity is held."""
        lib, i, still = self._lib, int(self.frames.fix[k]), self.settings.still_std
        sigmas = lib.noiseModel.Diagonal.Sigmas
        if still is not None:
            factors.push_back(lib.PriorFactorVector(self._key("v"), np.zeros(3), sigmas(np.full(3, still))))
            return True
        if i < 0:
            return False
        rate = self._rate[k] - gyro_bias
        v = self.fixes.v_n[i] - C_nb @ np.cross(rate, self.lever)
        std = np.hypot(self.fixes.velocity_std[i], np.linalg.norm(rate) * self.lever_std)
        has_velocity = bool(np.isfinite(v[:2]).all())
        if has_velocity:
            given = np.where(np.isfinite(v), std, UNKNOWN)
            factors.push_back(lib.PriorFactorVector(self._key("v"), np.nan_to_num(v), sigmas(given)))
        if self.settings.layers == 1 or self._height_holds(i):
            p_std = np.full(3, self.fixes.position_std[i])
            p_std[:2] = p_std[:2] if self.settings.layers == 1 else UNKNOWN
            factors.push_back(lib.GPSFactorArm(self._key("x"), self.fixes.p_n[i], self.lever, sigmas(p_std)))
        return has_velocity

    def _height_holds(self, i: int) -> bool:
        return not np.isfinite(self.fixes.v_n[i, 2]) and self.settings.still_std is None

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
