"""What GNSS says of velocity, and what the IMU's increments say of the same: at fixes, or between them.

A receiver's velocity is that of its fix. One that gives positions alone still gives the mean velocity between two
fixes, ``(p_k - p_k-1) / dt``, exactly, however far apart they are and whatever happened meanwhile; the increments
are then averaged over the same time. The antenna is ``l`` from the IMU, in b; with the attitude C0 at the first
fix it moves faster than the IMU by ``C0 M_k l``, ``M_k = C_k [omega_k]x`` or ``(C_k - C_k-1) / dt``. A stamp
that is late by tau shifts a velocity by the acceleration times tau.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import skew
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.inertial_increments import ImuGrid, InertialIncrements

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
    known = spanned & np.isfinite(fixes.v_n[:, :2]).all(axis=1)
    if known.any():
        omega = interpolated(fixes.t[known], imu.t, imu.omega_b)
        return FixVelocities(fixes.t[known], fixes.v_n[known], np.diag(fixes.velocity_std[known] ** 2), omega)
    t, p, variance = fixes.t[spanned], fixes.p_n[spanned], fixes.position_std[spanned] ** 2
    difference = np.diff(np.eye(len(t)), axis=0) / np.diff(t)[:, None]
    return MeanVelocities(t, difference @ p, (difference * variance) @ difference.T)


def _means(grid: ImuGrid, values: FloatArray) -> FloatArray:
    """Return the means (n - 1, ...) of values (m + 1, ...) at the edges, between the n times asked for."""
    shape = (-1, *[1] * (values.ndim - 1))
    areas = (values[1:] + values[:-1]) / 2 * grid.dt.reshape(shape)
    means: FloatArray = np.add.reduceat(areas, grid.at[:-1]) / np.add.reduceat(grid.dt, grid.at[:-1]).reshape(
        shape
    )
    return means
