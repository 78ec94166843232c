"""Whether a cube has changed: its measurements over the months, and against a certificate of its faces.

Compared are, along each axis, the difference and the mean of the two other pairs' parallelism, and the skews
(`measured_cube.common_and_difference`). What K2 of a unit adds is common to all that this unit measured: error i
is ``e_i + G_i K2``, so that between measurements of one unit, mounted as before, it cancels, and a drift is seen
as finely as the noise allows though the value itself is not known so well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from procedures.arrays import FloatArray
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import CubeMeasurement, common_and_difference
from procedures.statistics.significance import holm

CHANGED_P_VALUE = 0.01  # p-value, by Holm over all values, below which a cube is reported to have changed


@dataclass(frozen=True, slots=True, eq=False)
class CubeDrift:
    """How the values of ``names`` (n,) moved: last less first, and a straight line through all, each with 1 sigma.

    ``shift`` [rad], ``trend`` [rad per month]; ``chi2`` (n,) at ``dof`` tests that a value stayed; ``p_adjusted``
    by Holm over the values; ``chi2_of_trend`` (n,), at one less, tests the line.
    """

    names: tuple[str, ...]
    shift: FloatArray
    shift_std: FloatArray
    trend: FloatArray
    trend_std: FloatArray
    chi2: FloatArray
    chi2_of_trend: FloatArray
    dof: int
    p_adjusted: FloatArray

    @property
    def changed(self) -> tuple[str, ...]:
        """The values that moved beyond chance."""
        return tuple(name for name, p in zip(self.names, self.p_adjusted, strict=True) if p < CHANGED_P_VALUE)


@dataclass(frozen=True, slots=True, eq=False)
class CubeComparison:
    """Two statements of one cube: ``difference`` (n,) [rad], second less first, 1 sigma, chi-square over all."""

    names: tuple[str, ...]
    difference: FloatArray
    std: FloatArray
    chi2: float
    p_value: float


def drift(measurements: Sequence[CubeMeasurement], months: Sequence[float]) -> CubeDrift | None:
    """Return how a cube moved over its ``measurements``, taken at ``months``; None of fewer than two."""
    if len(measurements) < 2:
        return None
    first, *others = (measurement.cube.names for measurement in measurements)
    names = [name for name in first if all(name in other for other in others)]
    if not names:
        return None
    quantities, H = common_and_difference(names)
    value, covariance = _stacked(measurements, names, H)
    t = np.asarray(months, dtype=np.float64) - months[0]
    rows = [_moved(value[:, k], covariance[:, k, :, k], t) for k in range(len(quantities))]
    shift, shift_std, trend, trend_std, chi2, of_trend = np.array(rows).T
    dof = len(measurements) - 1
    p_adjusted = np.array(list(holm(dict(enumerate(stats.chi2.sf(chi2, dof)))).values()))
    return CubeDrift(quantities, shift, shift_std, trend, trend_std, chi2, of_trend, dof, p_adjusted)


def compare(first: MeasuredCube, second: MeasuredCube) -> CubeComparison | None:
    """Compare two independent statements, as of a laboratory and of IMUs; None if no value is in both."""
    names = [name for name in first.names if name in second.names]
    if not names:
        return None
    quantities, H = common_and_difference(names)
    parts = [(cube, [cube.names.index(name) for name in names]) for cube in (first, second)]
    value = [H @ cube.value[at] for cube, at in parts]
    covariance = sum((H @ cube.covariance[np.ix_(at, at)] @ H.T for cube, at in parts), np.zeros((len(H), len(H))))
    difference: FloatArray = value[1] - value[0]
    chi2 = float(difference @ np.linalg.solve(covariance, difference))
    std = np.sqrt(np.diag(covariance))
    return CubeComparison(quantities, difference, std, chi2, float(stats.chi2.sf(chi2, len(quantities))))


def _stacked(
    measurements: Sequence[CubeMeasurement], names: Sequence[str], H: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return values (m, q) and their covariance (m, q, m, q)."""
    m, q = len(measurements), len(H)
    value, covariance = np.zeros((m, q)), np.zeros((m, q, m, q))
    by_unit: dict[str, list[tuple[int, FloatArray]]] = {}
    for i, each in enumerate(measurements):
        at = [each.cube.names.index(name) for name in names]
        value[i] = H @ each.cube.value[at]
        covariance[i, :, i] = H @ each.noise[np.ix_(at, at)] @ H.T
        for share in each.shares:
            by_unit.setdefault(share.unit, []).append((i, H @ share.by_quadratic[at] * share.quadratic_std))
    for shares in by_unit.values():
        for i, first in shares:
            for j, second in shares:
                covariance[i, :, j] += first @ second.T
    return value, covariance


def _moved(y: FloatArray, covariance: FloatArray, t: FloatArray) -> tuple[float, ...]:
    """Return last less first and its sigma, slope and its sigma, chi-square of a constant and of a line."""
    ends = np.zeros(len(y))
    ends[0], ends[-1] = -1.0, 1.0
    constant, _ = _line(y, covariance, np.ones((len(y), 1)))
    if not np.ptp(t) > 0:
        return float(ends @ y), float(np.sqrt(ends @ covariance @ ends)), 0.0, np.inf, constant, constant
    line, (slope, std) = _line(y, covariance, np.stack((np.ones(len(y)), t), axis=1))
    return float(ends @ y), float(np.sqrt(ends @ covariance @ ends)), slope, std, constant, line


def _line(y: FloatArray, covariance: FloatArray, A: FloatArray) -> tuple[float, tuple[float, float]]:
    """Return chi-square of ``y = A x``, and the last x with its sigma (generalised least squares)."""
    L = np.linalg.cholesky(covariance)
    white_A, white_y = np.linalg.solve(L, A), np.linalg.solve(L, y)
    x = np.linalg.lstsq(white_A, white_y, rcond=None)[0]
    spread = np.linalg.inv(white_A.T @ white_A)
    return float(np.sum((white_y - white_A @ x) ** 2)), (float(x[-1]), float(np.sqrt(spread[-1, -1])))
