"""Poses of a table of means that contradict the others: a typing error, a sensor that was not at rest.

A pose is held against the fit to all others (`procedures.free_positions.norm_fit`) by the law of
`procedures.anomalies.held_out_rows`. What is left open is the scale s of the noise: the noise that is stated,
unless all poses scatter more. With chi2 of the others and f degrees of freedom,

    p(s) ~ prior(s) s^-f exp(-chi2 / (2 s^2))
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.anomalies.held_out_rows import HeldOut, WrongRow, find_wrong_rows, log_odds
from procedures.arrays import FloatArray, IntArray
from procedures.free_positions.norm_fit import LOWER_TRIANGLE, NormFit, fit_norm, norm_sigma
from procedures.inference import priors

SCALES = 4 * priors.AMPLITUDES  # points of a logarithmic grid over six decades and more


@dataclass(frozen=True, slots=True, eq=False)
class _Poses:
    """Means ``accel`` (n, 3) [output] with standard uncertainty ``std``; ``gravity`` [g]."""

    accel: FloatArray
    std: FloatArray
    gravity: float
    is_std_stated: bool

    def held_out(self, without: Sequence[int]) -> dict[int, HeldOut]:
        """Hold out each pose in turn where those ``without`` are gone; none whose others determine no fit."""
        inside = np.setdiff1d(np.arange(len(self.accel)), without)
        found = dict[int, HeldOut]()
        for row in inside.tolist():
            others = inside[inside != row]
            fit = fit_norm(self.accel[others], self.std[others], self.gravity)
            if isinstance(fit, NormFit):
                found[row] = self._against(fit, row, others)
        return found

    def _against(self, fit: NormFit, row: int, others: IntArray) -> HeldOut:
        noise = norm_sigma(fit.K, fit.b, self.accel, self.std)
        weight = np.hypot(noise, fit.excess)
        off, predicted = _predicted(fit, self.accel[row], self.gravity)
        sigmas = off / np.hypot(weight[row], predicted)
        chi2 = float(np.sum((fit.residual / weight[others]) ** 2))
        least = float(np.median(noise[others] / weight[others]))
        most = priors.SPAN * max(1.0, abs(sigmas))  # few others do not exclude that all poses scatter so
        scale, prior = np.geomspace(least, most, SCALES), np.zeros(SCALES)
        if self.is_std_stated:
            scale = np.append(scale, least)
            prior = np.append(prior + np.log(priors.ODDS_NAMED / SCALES), 0.0)
        right = prior - (fit.free + 1) * np.log(scale) - (chi2 + sigmas**2) / (2 * scale**2)
        return HeldOut(off, float(abs(sigmas)), log_odds(right, (sigmas / scale) ** 2, len(self.accel)))


def find_wrong_poses(
    accel: FloatArray, std: FloatArray, gravity: float, *, is_std_stated: bool
) -> tuple[WrongRow, ...]:
    """Find the poses that contradict the others, as they are likelier than none; ``off`` [g] is of the norm.

    Parameters
    ----------
    accel, std : (n, 3) [output], means and their standard uncertainties
    gravity : [g], the specific force in every pose
    is_std_stated : whether ``std`` holds noise that was measured; else it is the least that noise may be
    """
    poses = _Poses(accel, std, gravity, is_std_stated)
    return find_wrong_rows(poses.held_out, len(accel))


def _predicted(fit: NormFit, mean: FloatArray, gravity: float) -> tuple[float, float]:
    """Return how far the norm of a pose with output ``mean`` (3,) is off gravity [g], and u of the fit in it."""
    u = np.linalg.solve(fit.K, mean - fit.b)
    length = float(np.linalg.norm(u))
    w = np.linalg.solve(fit.K.T, u / length)
    rows, columns = LOWER_TRIANGLE
    gradient = -np.concatenate((w[rows] * u[columns], w))
    return length - gravity, float(np.sqrt(gradient @ fit.fit.covariance @ gradient))
