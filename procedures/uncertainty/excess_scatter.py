"""Scatter that the model does not explain, and the effect of temperature on the parameters.

Where whitened squares fail the test at `DOUBTFUL_P_VALUE`, each observation lacks the variance squares over
degrees of freedom less one (Birge, Phys. Rev. 40, 1932); below that nothing is added unless a diagnosis says so.

Temperature: bias and scale factor of each axis may change by ``c dT``. Columns C in the whitened rows, regressed
on the residual with ``M = 1 - J P J'``: ``c = (C'M C)^-1 C' r``. A parameter is moved by ``d = G C c``, known to
``v = G C (C'M C)^-1 C'G'``; ``d^2 - v``, unbiased for the square, is its variance, counted where all six fail the
test.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincc

from procedures.arrays import BoolArray, FloatArray
from procedures.calibration.solution_values import DOUBTFUL_P_VALUE
from procedures.counts.sample_records import Series
from procedures.statistics.least_squares import Fit
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit
from procedures.uncertainty import sources
from procedures.uncertainty.sources import GivenValues, Shares, SourceCell

MIN_EIGENVALUE_SHARE = 1e-9  # of the largest eigenvalue: combinations that the fit absorbs whole


@dataclass(frozen=True, slots=True, eq=False)
class TemperatureEffect:
    """Columns (n, 6), coefficients (6,) per kelvin, covariance (6, 6); the squares they take, and their number."""

    columns: FloatArray
    coefficients: FloatArray
    covariance: FloatArray
    chi2: float
    rank: int

    @property
    def dof(self) -> float:
        """Degrees of freedom of the square of a shift of ``sqrt(chi2)`` sigmas: ``var / mean^2 = 4 / chi2``."""
        return max(self.chi2 / 2, 1.0)

    def variance(self, through: FloatArray) -> FloatArray:
        """Return the variance (15,) of parameters that move with the rows by ``through`` (15, n)."""
        moved = through @ self.columns
        noise = np.einsum("ip,pq,iq->i", moved, self.covariance, moved)
        found: FloatArray = np.maximum((moved @ self.coefficients) ** 2 - noise, 0.0)
        return found


def temperature_effect(fit: Fit, columns: FloatArray | None) -> TemperatureEffect | None:
    """Regress ``columns`` (n, 6) on a fit's residual; None without them, or where they explain nothing."""
    if columns is None or not np.any(columns):
        return None
    absorbed = fit.jacobian @ (fit.covariance @ (fit.jacobian.T @ columns))
    values, vectors = np.linalg.eigh(columns.T @ (columns - absorbed))
    kept = values > MIN_EIGENVALUE_SHARE * np.max(np.sum(columns**2, axis=0))
    if not np.any(kept):
        return None
    covariance = vectors[:, kept] / values[kept] @ vectors[:, kept].T
    pull = columns.T @ fit.residual
    chi2, rank = float(pull @ covariance @ pull), int(kept.sum())
    if gammaincc(rank / 2, chi2 / 2) >= DOUBTFUL_P_VALUE:
        return None
    return TemperatureEffect(columns, covariance @ pull, covariance, chi2, rank)


def warmer(series: Sequence[Series]) -> FloatArray | None:
    """Return by how much every recording is warmer (m,) [K] than their mean; None where one has no temperature."""
    means = [one.temperature[np.isfinite(one.temperature)] for one in series]
    if not means or any(len(each) == 0 for each in means):
        return None
    found = np.array([each.mean() for each in means])
    warm: FloatArray = found - found.mean()
    return warm


def accelerometer_columns(joint: TriadFit) -> FloatArray | None:
    """Return what a kelvin's change of bias [k] and scale [1] of every axis does to the rows (n, 6)."""
    series: list[Series] = [dwell.series for _, dwell in joint.seen.dwells]
    series += [rest.series for _, rest in joint.rests.rests.rests] if joint.rests is not None else []
    warm = warmer(series)
    if warm is None:
        return None
    columns, n = np.zeros((len(joint.fit.residual), 6)), len(joint.seen.dwells)
    _fill(columns[: 3 * n], warm[:n], joint.k, joint.seen.rate, joint.sigma)
    if joint.rests is not None:
        along = np.linalg.solve(joint.K.T, joint.rests.up.T).T * (warm[n:] / joint.rests.sigma)[:, None]
        columns[joint.rests.rows, :3] = along * joint.k
        columns[joint.rests.rows, 3:] = along * joint.rests.rests.rate
    return columns


def gyroscope_columns(gyroscope: GyroscopeFit) -> FloatArray | None:
    """Return the same of dwells and turns (n, 6)."""
    joint, turns = gyroscope.joint, gyroscope.turns
    steps = [dwell.series for _, dwell in joint.seen.dwells] + [turn.record.series for turn in turns]
    warm = warmer(steps)
    if warm is None:
        return None
    columns, n = np.zeros((len(joint.fit.residual), 6)), len(joint.seen.dwells)
    _fill(columns[: 3 * n], warm[:n], joint.k, joint.seen.rate, joint.sigma)
    seconds = np.array([turn.seconds for turn in turns])[:, None] * joint.k
    totals = np.array([turn.total for turn in turns]).reshape(-1, 3)
    _fill(columns[3 * n : 3 * (n + len(turns))], warm[n:], seconds, totals, gyroscope.turn_sigma)
    return columns


def _fill(rows: FloatArray, warm: FloatArray, bias: FloatArray, output: FloatArray, sigma: FloatArray) -> None:
    """Write bias and scale columns of steps into ``rows`` (3 m, 6): ``bias`` is the output per unit of bias."""
    one = warm[:, None] / sigma
    for axis in range(3):
        rows[axis::3, axis] = (one * bias)[:, axis]
        rows[axis::3, 3 + axis] = (one * output)[:, axis]


def unexplained(
    triad: str,
    chi2: float,
    dof: int,
    observed: BoolArray,
    temperature: TemperatureEffect | None,
    is_left: bool = False,
) -> Shares:
    """Return the variance (n,) that the rows ``observed`` (n,) lack, none where the squares pass the test.

    What ``temperature`` takes of the squares is explained by it and counted there. ``is_left``: a diagnosis says
    that the test fails, whatever this one of all squares together says.
    """
    if temperature is not None:
        chi2, dof = chi2 - temperature.chi2, dof - temperature.rank
    if dof <= 0 or chi2 <= dof or (not is_left and gammaincc(dof / 2, chi2 / 2) >= DOUBTFUL_P_VALUE):
        return {}
    ratio = chi2 / dof
    cell = SourceCell(sources.UNEXPLAINED, triad, max(dof * (1 - 1 / ratio) ** 2, 1.0))
    return {cell: (ratio - 1) * np.where(observed, 1.0, 0.0)}


def unexplained_within(triad: str, joint: TriadFit, dof: int, squares: float) -> Shares:
    """Return the variance (n,) that the rows of dwells lack by what drifts within them.

    ``squares`` of the counting noise of their means are added to each, as well known as the fit's ``dof`` shows.
    """
    m = 3 * len(joint.seen.dwells)
    if squares <= 0 or not m:
        return {}
    share = np.zeros(len(joint.fit.residual))
    share[:m] = squares * ((joint.expected / joint.sigma) ** 2).ravel()
    return {SourceCell(sources.UNEXPLAINED, triad, max(dof * (squares / (1 + squares)) ** 2, 1.0)): share}


def moved_values(triad: str, inputs: GivenValues) -> Shares:
    """Return the variance (15,) of k, E and D, each in its unit, for what effects took that is not theirs.

    Between bounds any change is as likely as another (JCGM 100:2008, 4.3.7).
    """
    left = (inputs.unexplained or {}).get(triad)
    if left is None or left.moved is None:
        return {}
    return {SourceCell(sources.UNEXPLAINED, f"{triad} moved"): left.moved**2 / 3}
