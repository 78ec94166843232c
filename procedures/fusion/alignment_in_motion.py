"""Attitude in motion from GNSS velocity: what the IMU's velocity increments must be turned by to be GNSS's.

In n, with the attitude C0 and the velocity v0 at the first of the fixes and constant biases,

    v_k = v0 + C0 alpha_k(bg, ba) + C0 M_k l + g t_k + a_k tau + noise,   g = (0, 0, -gravity)

is fitted for C0, v0, bg, ba and, where they are not given, the antenna's lever arm l and the offset tau of GNSS's
stamps together: the integral of Han 2022, eq. 3 (III.C, the joint refinement, less what needs a camera). The noise
is GNSS's own, white, and that of accelerometer and gyro integrated. All is started from the best rotation for
biases of zero (Wahba's problem), and once more from a quarter turn to each side and from behind: what is nearly as
good and points elsewhere, a strange chi2 or a wide sigma are reasons to go on waiting.

A receiver without velocity gives the means between its fixes, ``(p_k - p_k-1) / dt``; the increments are then
averaged over the same time. The antenna moves faster than the IMU by ``C0 M_k l``, ``M_k = C_k [omega_k]x`` or
``(C_k - C_k-1) / dt``. A stamp late by tau shifts a velocity by acceleration times tau.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky
from scipy.linalg.lapack import dtrtrs

from procedures.arrays import FloatArray, IntArray, interpolated
from procedures.frames import rotation, skew, vertical_rotation, wahba_rotation
from procedures.fusion.fusion_records import (
    MAX_TILT_STD,
    MAX_TIME_OFFSET_STD_S,
    MAX_YAW_STD,
    AlignmentState,
    GnssFixes,
    ImuNoise,
    ImuSeries,
    Waiting,
    in_degrees,
)
from procedures.fusion.preintegration import ImuGrid, InertialIncrements, grid, imu_gaps, integrate

ACCELERATION_HALF_SPAN_S = 0.03  # s, over which an acceleration is taken: longer than a propeller's turn


@dataclass(frozen=True, slots=True, eq=False)
class PredictedVelocities:
    """At n velocities: ``alpha`` (n, 3) [m/s] and, each (n, 3, 3), its slopes by the biases, and M of the arm.

    ``by_time`` (n, 3) [m/s2] is the slope of alpha over time.
    """

    alpha: FloatArray
    by_gyro: FloatArray
    by_accel: FloatArray
    arm: FloatArray
    by_time: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FixVelocities:
    """Velocities ``v`` (n, 3) [m/s] at ``t`` (n,) [s], nan where there is none; ``noise`` (n, n) of each axis."""

    t: FloatArray
    v: FloatArray
    noise: FloatArray
    omega_b: FloatArray

    @property
    def elapsed(self) -> FloatArray:
        """Time (n,) [s] since the first fix."""
        since: FloatArray = self.t - self.t[0]
        return since

    def reach(self, grid: ImuGrid, made: InertialIncrements, gyro_bias: FloatArray) -> PredictedVelocities:
        """Return increments made at all edges of the grid as they are at the fixes; ``gyro_bias`` (3,) [rad/s]."""
        k, edges = grid.at, np.concatenate(([0.0], np.cumsum(grid.dt)))
        ends = np.clip([edges[k] - ACCELERATION_HALF_SPAN_S, edges[k] + ACCELERATION_HALF_SPAN_S], 0.0, edges[-1])
        alpha = [interpolated(t, edges, made.alpha) for t in ends]
        slope = (alpha[1] - alpha[0]) / (ends[1] - ends[0])[:, None]
        arm = made.C[k] @ skew(self.omega_b - gyro_bias)
        return PredictedVelocities(made.alpha[k], made.by_gyro[k], made.by_accel[k], arm, slope)


@dataclass(frozen=True, slots=True, eq=False)
class MeanVelocities:
    """Mean velocities ``v`` (n - 1, 3) [m/s] between fixes at ``t`` (n,) [s]; ``noise`` as in `FixVelocities`."""

    t: FloatArray
    v: FloatArray
    noise: FloatArray

    @property
    def elapsed(self) -> FloatArray:
        """Time (n - 1,) [s] since the first fix, of the middles."""
        middle: FloatArray = (self.t[1:] + self.t[:-1]) / 2 - self.t[0]
        return middle

    def reach(self, grid: ImuGrid, made: InertialIncrements, _gyro_bias: FloatArray) -> PredictedVelocities:
        """Return increments made at all edges of the grid, averaged between fixes; ``_gyro_bias`` (3,) unused."""
        dt = np.diff(self.t)[:, None]
        turned, slope = np.diff(made.C[grid.at], axis=0) / dt[:, None], np.diff(made.alpha[grid.at], axis=0) / dt
        means = [_means(grid, part) for part in (made.alpha, made.by_gyro, made.by_accel)]
        return PredictedVelocities(means[0], means[1], means[2], turned, slope)


def observed_velocities(imu: ImuSeries, fixes: GnssFixes) -> FixVelocities | MeanVelocities:
    """Return what the fixes that the IMU spans say: their velocities, or where none has one the means between."""
    spanned = (fixes.t >= imu.t[0]) & (fixes.t <= imu.t[-1])
    known = spanned & fixes.has_velocity
    if known.any():
        omega = interpolated(fixes.t[known], imu.t, imu.omega_b)
        return FixVelocities(fixes.t[known], fixes.v_n[known], np.diag(fixes.velocity_std[known] ** 2), omega)
    t, p, variance = fixes.t[spanned], fixes.p_n[spanned], fixes.position_std[spanned] ** 2
    difference = np.diff(np.eye(len(t)), axis=0) / np.diff(t)[:, None]
    return MeanVelocities(t, difference @ p, (difference * variance) @ difference.T)


def _means(grid: ImuGrid, values: FloatArray) -> FloatArray:
    """Return the means (n - 1, ...) of values (m + 1, ...) at the edges, between the n times asked for."""
    dt = grid.dt.reshape(-1, *[1] * (values.ndim - 1))
    areas = (values[1:] + values[:-1]) / 2 * dt
    means: FloatArray = np.add.reduceat(areas, grid.at[:-1]) / np.add.reduceat(dt, grid.at[:-1])
    return means


MAX_ITERATIONS = 15
UNMEASURED_VELOCITY_STD = 300.0  # m/s, 1 sigma of a velocity of which nothing is measured
STEP_TOLERANCE = 1e-3  # of a sigma, by which a last step may move
MIN_VELOCITIES = 5
MIN_MINIMA_ANGLE = np.radians(10.0)  # between two minima that are not one
MIN_CHI2_MARGIN = 20.0  # of chi2, by which the second best must be worse
MAX_CHI2_PER_DOF = 2.0  # chi2 / dof
ACCEL_NOISE_FACTOR = 2.5  # by vibration, scale factor and misalignment, of a flight's accelerometers (EuRoC)
LEVER, OFFSET = slice(9, 12), 12  # in the parameters behind the rotation
MAX_TIME_SHIFTS = 5  # times that stamps are shifted to where they belong, at most, until it is by no more than
TIME_SHIFT_TOLERANCE_S = 2e-3  # s
MAX_TIME_OFFSET_S = 2.0  # s
START_HEADINGS = (0.0, np.pi / 2, np.pi, -np.pi / 2)


@dataclass(frozen=True, slots=True, eq=False)
class MovingAligner:
    """What stays the same: noise, ``gravity`` [m/s2], ``earth_n`` (3,) [rad/s], ``lever`` (3,) [m] in b.

    ``lever_std`` [m] and ``offset_std`` [s] are 1 sigma of a lever arm and of a time offset, about 0, that are to
    be estimated; None: the lever arm is as given, the stamps are right.
    """

    noise: ImuNoise
    gravity: float
    earth_n: FloatArray
    lever: FloatArray
    lever_std: float | None = None
    offset_std: float | None = None

    def align(self, imu: ImuSeries, fixes: GnssFixes) -> AlignmentState | Waiting:
        """Align by all fixes that the IMU spans, or say what is missing."""
        offset, best = 0.0, list[FloatArray]()
        for _ in range(MAX_TIME_SHIFTS):
            shifted = offset  # what the fixes are shifted by below: the last step is in the solution alone
            seen = observed_velocities(imu, fixes.shifted(shifted))
            if len(seen.v) < MIN_VELOCITIES:
                return Waiting(f"{len(seen.v)} GNSS velocities within the IMU's data, {MIN_VELOCITIES} are needed")
            problem = _Problem(self, imu, seen, shifted)
            found = problem.minima(best or problem.starts())
            step = float(found[0].x[OFFSET])
            if abs(step) < TIME_SHIFT_TOLERANCE_S:
                break
            best, offset = [found[0].C], float(np.clip(offset + step, -MAX_TIME_OFFSET_S, MAX_TIME_OFFSET_S))
        if best:  # a shift hardly moves the minima: it was followed from the best, the others are compared at last
            found = problem.minima(best + problem.starts())
        return _judged(problem, found, shifted)


@dataclass(frozen=True, slots=True, eq=False)
class _Minimum:
    C: FloatArray
    x: FloatArray  # v0, gyro bias, accelerometer bias, lever arm, time offset
    chi2: float
    rows: int
    covariance: FloatArray
    now: FloatArray  # the attitude at the last fix
    turned: FloatArray  # d (rotation about n at the last fix) / d parameters, (3, 16)


class _Problem:
    """One set of fixes: residual, Jacobian and whitening."""

    def __init__(
        self, owner: MovingAligner, imu: ImuSeries, seen: FixVelocities | MeanVelocities, shifted: float
    ) -> None:
        self.owner, self.seen = owner, seen
        self.grid: ImuGrid = grid(imu, seen.t)
        self.elapsed = seen.elapsed
        noise, s = owner.noise, np.minimum.outer(self.elapsed, self.elapsed)
        longer = np.maximum.outer(self.elapsed, self.elapsed)
        walk = (ACCEL_NOISE_FACTOR * noise.accel) ** 2 * s
        tilt = (owner.gravity * noise.gyro) ** 2 * s**2 * (3 * longer - s) / 6  # of a horizontal axis
        for gap in imu_gaps(imu):
            since = np.maximum(self.elapsed - (gap.last - seen.t[0]), 0.0)
            walk += (gap.force_std * gap.length) ** 2 * np.outer(since > 0, since > 0)
            tilt += (owner.gravity * gap.rate_std * gap.length) ** 2 * np.outer(since, since)
        self.white = list[tuple[int, IntArray, FloatArray]]()
        for axis in range(3):
            rows = np.flatnonzero(np.isfinite(seen.v[:, axis]))
            if len(rows):  # not so the vertical of a receiver without it
                R = seen.noise + walk + (tilt if axis < 2 else 0.0)
                self.white.append((axis, rows, cholesky(R[np.ix_(rows, rows)], lower=True)))
        lever_std, offset_std = owner.lever_std or np.inf, owner.offset_std or np.inf
        self.prior = np.repeat(
            [UNMEASURED_VELOCITY_STD, noise.gyro_bias, noise.accel_bias, lever_std, offset_std], [3, 3, 3, 3, 1]
        )
        self.free = np.isfinite(self.prior)
        self.expected = np.r_[np.zeros(9), owner.lever, -shifted if owner.offset_std else 0.0]

    def starts(self) -> list[FloatArray]:
        """Return the rotation for biases of zero that fits the changes of velocity best, also turned around."""
        zero = np.zeros(3)
        alpha = self.seen.reach(self.grid, integrate(self.grid, zero, zero), zero).alpha
        v = self.seen.v
        seen = np.where(np.isfinite(v), v, 0.0) + np.outer(self.elapsed, [0, 0, self.owner.gravity])
        C = wahba_rotation((seen - seen.mean(axis=0)).T @ (alpha - alpha.mean(axis=0)))
        return [vertical_rotation(turn) @ C for turn in START_HEADINGS]

    def minima(self, starts: list[FloatArray]) -> list[_Minimum]:
        """Return what is reached from attitudes, the best first."""
        return sorted((self.refine(C) for C in starts), key=lambda each: each.chi2)

    def refine(self, C: FloatArray) -> _Minimum:
        """Return the minimum that Gauss-Newton reaches from an attitude."""
        x = self.expected.copy()
        x[:3] = np.nan_to_num(self.seen.v[0])
        for _ in range(MAX_ITERATIONS):
            r, J, made = self._whitened(C, x)
            normal = J.T @ J
            step: FloatArray = np.asarray(np.linalg.solve(normal, -(J.T @ r)), np.float64)
            C = rotation(step[:3]) @ C
            x[self.free] += step[3:]
            if step @ normal @ step < STEP_TOLERANCE**2:
                break
        r, J, made = self._whitened(C, x)
        known = np.concatenate(([True, True, True], self.free))
        covariance = np.zeros((len(known), len(known)))
        covariance[np.ix_(known, known)] = np.linalg.inv(J.T @ J)
        # a bias of the gyro turns the last attitude by -Phi in b0
        turned = np.zeros((3, len(covariance)))
        turned[:, :3], turned[:, 6:9] = np.eye(3), C @ made.by_accel[-1]
        return _Minimum(C, x, float(r @ r), len(r), covariance, C @ made.C[-1], turned)

    def _whitened(self, C: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray, InertialIncrements]:
        made = integrate(self.grid, x[3:6], x[6:9], C.T @ self.owner.earth_n)
        reach = self.seen.reach(self.grid, made, x[3:6])
        late = x[OFFSET]
        moved = np.einsum("ij,nj->ni", C, reach.alpha + reach.by_time * late)
        arm = np.einsum("ij,njk,k->ni", C, reach.arm, x[LEVER])
        down = np.array([0.0, 0.0, self.owner.gravity])
        predicted = x[:3] + moved + arm - np.outer(self.elapsed + late, down)
        J = np.zeros((len(predicted), 3, 3 + len(x)))
        J[:, :, :3] = -skew(moved + arm)
        J[:, range(3), range(3, 6)] = 1.0
        J[:, :, 6:9], J[:, :, 9:12] = C @ reach.by_gyro, C @ reach.by_accel
        J[:, :, 12:15], J[:, :, 15] = C @ reach.arm, np.einsum("ij,nj->ni", C, reach.by_time) - down
        J = J[:, :, np.concatenate(([True, True, True], self.free))]
        parts, rows = [], []
        for axis, known, L in self.white:
            both = np.column_stack((predicted[known, axis] - self.seen.v[known, axis], J[known, axis]))
            both, _ = dtrtrs(L, both, lower=1)
            parts.append(both[:, 0])
            rows.append(both[:, 1:])
        prior = np.hstack((np.zeros((int(self.free.sum()), 3)), np.diag(1 / self.prior[self.free])))
        expected = ((x - self.expected) / self.prior)[self.free]
        return np.concatenate((*parts, expected)), np.vstack((*rows, prior)), made


def _judged(problem: _Problem, found: list[_Minimum], offset: float) -> AlignmentState | Waiting:
    best = found[0]
    at_end = best.turned @ best.covariance @ best.turned.T
    t = problem.seen.t
    noise = problem.owner.noise.gyro**2 * (t[-1] - t[0])
    tilt_std, yaw_std = np.sqrt(max(at_end[0, 0], at_end[1, 1]) + noise), np.sqrt(at_end[2, 2] + noise)
    misfit = best.chi2 / max(best.rows - 3 - int(problem.free.sum()), 1)
    why = _why_waiting(best, found[1:], misfit, float(tilt_std), float(yaw_std))
    if why:
        return Waiting(why)
    x = best.x
    return AlignmentState(
        float(t[0]), best.C, x[:3], x[3:6], x[6:9], best.covariance, float(t[-1]), best.now, float(tilt_std),
        float(yaw_std), misfit, x[LEVER], offset + float(x[OFFSET]),
    )  # fmt: skip


def _why_waiting(best: _Minimum, others: list[_Minimum], misfit: float, tilt_std: float, yaw_std: float) -> str:
    if misfit > MAX_CHI2_PER_DOF:
        return (
            f"IMU and GNSS velocity do not match (chi2 per degree of freedom {misfit:.1f}, at most "
            f"{MAX_CHI2_PER_DOF:g}): check time stamps, noise densities and velocity_std_m_s"
        )
    if tilt_std > MAX_TILT_STD or yaw_std > MAX_YAW_STD:
        tilt, yaw, tilt_asked, yaw_asked = in_degrees(tilt_std, yaw_std, MAX_TILT_STD, MAX_YAW_STD)
        return (
            f"tilt is known to {tilt:.1f} deg and yaw to {yaw:.1f} deg (u), {tilt_asked:.0f} and "
            f"{yaw_asked:.0f} are needed: change the velocity more"
        )
    for other in others:
        apart = np.arccos(np.clip((np.trace(other.C @ best.C.T) - 1) / 2, -1, 1))
        if apart > MIN_MINIMA_ANGLE and other.chi2 - best.chi2 < MIN_CHI2_MARGIN:
            return f"two attitudes {np.degrees(apart):.0f} deg apart explain the motion: change its velocity more"
    std = float(np.sqrt(best.covariance[-1, -1]))
    if std <= MAX_TIME_OFFSET_STD_S:
        return ""
    return (
        f"the time offset is known to {std * 1e3:.0f} ms (u), {MAX_TIME_OFFSET_STD_S * 1e3:.0f} are needed: "
        f"change the velocity more, or give time_offset_s"
    )
