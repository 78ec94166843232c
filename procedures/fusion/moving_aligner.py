"""Attitude in motion from GNSS velocity: what the IMU's velocity increments must be turned by to be GNSS's.

In n, with the attitude C0 and the velocity v0 at the first of the fixes and constant biases,

    v_k + C0 C_k (omega_k x l) = v0 + C0 alpha_k(bg, ba) + g t_k + noise,   g = (0, 0, -gravity)

is fitted for C0, v0, bg, ba together (P3 III.C, the joint refinement, less what needs a camera). This is the
integral of P3's eq. 3: nothing is differentiated, so that the noise of GNSS stays what it is. The noise is GNSS's
own, white, and that of accelerometer and gyro integrated. All is started from the best rotation for biases of zero
(Wahba's problem), and once more from a quarter turn to each side and from behind: what is nearly as good and
points elsewhere, a strange chi2 or a wide sigma are reasons to go on waiting.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from procedures.arrays import FloatArray, IntArray
from procedures.frames import rotation, vertical_rotation
from procedures.fusion.alignment import SETTLED_TILT, SETTLED_YAW, Aligned, Waiting
from procedures.fusion.inertial_increments import Grid, Increments, grid, integrate, products
from procedures.fusion.records import GnssFixes, ImuNoise, ImuSeries

ROUNDS = 15
FASTEST = 300.0  # m/s, 1 sigma of a velocity of which nothing is measured
SMALL = 1e-3  # of a sigma, by which a last step may move
FEWEST = 5
DIFFERENT = np.radians(10.0)  # between two minima that are not one
MARGIN = 20.0  # of chi2, by which the second best must be worse
STRANGE = 2.0  # chi2 / dof
SHAKEN = 2.5  # what vibration, scale factor and misalignment make of an accelerometer's noise on a flight (EuRoC)
OTHERS = (0.0, np.pi / 2, np.pi, -np.pi / 2)


@dataclass(frozen=True, slots=True, eq=False)
class MovingAligner:
    """What stays the same: noise, ``gravity`` [m/s2], ``earth_n`` (3,) [rad/s], ``lever`` (3,) [m] in b."""

    noise: ImuNoise
    gravity: float
    earth_n: FloatArray
    lever: FloatArray

    def align(self, imu: ImuSeries, fixes: GnssFixes) -> Aligned | Waiting:
        """Align by all fixes with a velocity that the IMU spans, or say what is missing."""
        known = np.isfinite(fixes.v_n[:, :2]).all(axis=1) & (fixes.t >= imu.t[0]) & (fixes.t <= imu.t[-1])
        if np.count_nonzero(known) < FEWEST:
            return Waiting(f"{np.count_nonzero(known)} GNSS velocities within the IMU's data, {FEWEST} are needed")
        problem = _Problem(self, imu, fixes.t[known], fixes.v_n[known], fixes.velocity_std[known])
        start = problem.wahba()
        found = [problem.refine(vertical_rotation(turn) @ start) for turn in OTHERS]
        return _judged(problem, sorted(found, key=lambda each: each.chi2))


@dataclass(frozen=True, slots=True, eq=False)
class _Minimum:
    C: FloatArray
    v: FloatArray
    bias: FloatArray  # gyro, accelerometer
    chi2: float
    rows: int
    covariance: FloatArray
    now: FloatArray  # the attitude at the last fix
    turned: FloatArray  # d (rotation about n at the last fix) / d parameters, (3, 12)


class _Problem:
    """One set of fixes: residual, Jacobian and whitening."""

    def __init__(
        self, owner: MovingAligner, imu: ImuSeries, t: FloatArray, v: FloatArray, std: FloatArray
    ) -> None:
        self.owner, self.t, self.v = owner, t, v
        self.grid: Grid = grid(imu, t)
        self.elapsed = t - t[0]
        rate = np.stack([np.interp(t, imu.t, imu.omega_b[:, i]) for i in range(3)], axis=1)
        self.arm_rate = np.cross(rate, owner.lever)
        noise, s = owner.noise, np.minimum.outer(self.elapsed, self.elapsed)
        longer = np.maximum.outer(self.elapsed, self.elapsed)
        walk = (SHAKEN * noise.accel) ** 2 * s
        tilt = (owner.gravity * noise.gyro) ** 2 * s**2 * (3 * longer - s) / 6  # of a horizontal axis
        self.white = list[tuple[int, IntArray, FloatArray]]()
        for axis in range(3):
            rows = np.flatnonzero(np.isfinite(v[:, axis]))
            if not len(rows):
                continue  # a receiver without vertical velocity
            R = np.diag(std**2) + walk + (tilt if axis < 2 else 0.0)
            self.white.append((axis, rows, cholesky(R[np.ix_(rows, rows)], lower=True)))
        self.prior = np.r_[np.full(3, FASTEST), np.full(3, noise.gyro_bias), np.full(3, noise.accel_bias)]

    def wahba(self) -> FloatArray:
        """Return the rotation for biases of zero that fits the changes of velocity best."""
        alpha = integrate(self.grid, np.zeros(3), np.zeros(3)).alpha
        seen = np.where(np.isfinite(self.v), self.v, 0.0) + np.outer(self.elapsed, [0, 0, self.owner.gravity])
        U, _, Vt = np.linalg.svd((seen - seen.mean(axis=0)).T @ (alpha - alpha.mean(axis=0)))
        best: FloatArray = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
        return best

    def refine(self, C: FloatArray) -> _Minimum:
        """Return the minimum that Gauss-Newton reaches from an attitude."""
        v, bias = self.v[0].copy(), np.zeros(6)
        v[~np.isfinite(v)] = 0.0
        for _ in range(ROUNDS):
            r, J, made = self._whitened(C, v, bias)
            normal = J.T @ J
            step: FloatArray = np.asarray(np.linalg.solve(normal, -(J.T @ r)), np.float64)
            C, v, bias = rotation(step[:3]) @ C, v + step[3:6], bias + step[6:]
            if step @ normal @ step < SMALL**2:
                break
        r, J, made = self._whitened(C, v, bias)
        covariance: FloatArray = np.asarray(np.linalg.inv(J.T @ J), np.float64)
        # a bias of the gyro turns the last attitude by -Phi in b0
        turned = np.hstack((np.eye(3), np.zeros((3, 3)), C @ made.by_accel[-1], np.zeros((3, 3))))
        return _Minimum(C, v, bias, float(r @ r), len(r), covariance, C @ made.C[-1], turned)

    def _whitened(
        self, C: FloatArray, v: FloatArray, bias: FloatArray
    ) -> tuple[FloatArray, FloatArray, Increments]:
        made = integrate(self.grid, bias[:3], bias[3:], self._earth_b(C, bias))
        moved = np.einsum("ij,nj->ni", C, made.alpha)
        arm = np.einsum("ij,njk,nk->ni", C, made.C, self.arm_rate)
        said = v + moved + arm - np.outer(self.elapsed, [0.0, 0.0, self.owner.gravity])
        J = np.zeros((len(self.t), 3, 12))
        J[:, :, :3] = -_skew(moved + arm)
        J[:, range(3), range(3, 6)] = 1.0
        J[:, :, 6:9], J[:, :, 9:] = C @ made.by_gyro, C @ made.by_accel
        parts, rows = [], []
        for axis, known, L in self.white:
            both = np.column_stack((said[known, axis] - self.v[known, axis], J[known, axis]))
            both = solve_triangular(L, both, lower=True, check_finite=False)
            parts.append(both[:, 0])
            rows.append(both[:, 1:])
        prior = np.hstack((np.zeros((9, 3)), np.diag(1 / self.prior)))
        return np.concatenate((*parts, np.r_[v, bias] / self.prior)), np.vstack((*rows, prior)), made

    def _earth_b(self, C: FloatArray, bias: FloatArray) -> FloatArray:
        """Return the Earth's rate in b over the grid, by the attitudes so far; 1e-4 rad/s needs no iteration."""
        C_b0b = products(rotation((self.grid.omega_b - bias[:3]) * self.grid.dt[:, None]))[:-1]
        earth_b: FloatArray = np.swapaxes(C @ C_b0b, 1, 2) @ self.owner.earth_n
        return earth_b


def _judged(problem: _Problem, found: list[_Minimum]) -> Aligned | Waiting:
    best = found[0]
    at_end = best.turned @ best.covariance @ best.turned.T
    noise = problem.owner.noise.gyro**2 * problem.elapsed[-1]
    tilt_std, yaw_std = np.sqrt(max(at_end[0, 0], at_end[1, 1]) + noise), np.sqrt(at_end[2, 2] + noise)
    misfit = best.chi2 / max(best.rows - 12, 1)
    why = _why_waiting(best, found[1:], misfit, float(tilt_std), float(yaw_std))
    if why:
        return Waiting(why)
    return Aligned(
        float(problem.t[0]), best.C, best.v, best.bias[:3], best.bias[3:], best.covariance,
        float(problem.t[-1]), best.now, float(tilt_std), float(yaw_std), misfit,
    )  # fmt: skip


def _why_waiting(best: _Minimum, others: list[_Minimum], misfit: float, tilt_std: float, yaw_std: float) -> str:
    if misfit > STRANGE:
        return (
            f"IMU and GNSS velocity do not fit each other (chi2 per degree of freedom {misfit:.1f}, at most "
            f"{STRANGE:g}): look at time stamps, noise densities and velocity_std_m_s"
        )
    if tilt_std > SETTLED_TILT or yaw_std > SETTLED_YAW:
        tilt, yaw, tilt_asked, yaw_asked = np.degrees(
            np.minimum([tilt_std, yaw_std, SETTLED_TILT, SETTLED_YAW], np.pi)
        )
        return (
            f"tilt is known to {tilt:.1f} deg and yaw to {yaw:.1f} deg 1 sigma, {tilt_asked:.0f} and "
            f"{yaw_asked:.0f} are needed: it must change its velocity more"
        )
    for other in others:
        apart = np.arccos(np.clip((np.trace(other.C @ best.C.T) - 1) / 2, -1, 1))
        if apart > DIFFERENT and other.chi2 - best.chi2 < MARGIN:
            return f"two attitudes {np.degrees(apart):.0f} deg apart explain the motion: change its velocity more"
    return ""


def _skew(v: FloatArray) -> FloatArray:
    matrix = np.zeros((*v.shape[:-1], 3, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    skew: FloatArray = matrix - np.swapaxes(matrix, -1, -2)
    return skew
