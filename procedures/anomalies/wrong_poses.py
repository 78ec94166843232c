"""Poses of a table of means that contradict the others: a typing error, a sensor that was not at rest.

A pose is held against the fit to all others (`procedures.free_positions.norm_fit`). Its error z [sigma] has the
marginal likelihood of one coefficient (`procedures.inference.odds`), averaged over the scale s of the noise that
the others show: the noise that is stated, unless all poses scatter more. With chi2 of the others and f degrees of
freedom,

    p(s) ~ prior(s) s^-f exp(-chi2 / (2 s^2))

Poses are held out one after the other, each time the likeliest. The odds of a set are the product of these steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.free_positions.norm_fit import LOWER_TRIANGLE, NormFit, fit_norm, norm_sigma
from procedures.inference import odds, priors
from procedures.inference.marginal import log_mean

MOST_WRONG = 4  # poses of one table: with more of them it is not worth a calibration
LEAST_RIGHT = 0.75  # of the poses: those that contradict are few
SCALES = 4 * priors.AMPLITUDES  # points of a logarithmic grid over six decades and more


@dataclass(frozen=True, slots=True)
class WrongPose:
    """A pose that contradicts the others.

    ``row`` is its number from 0, ``off`` [g] its norm less gravity by the fit to the others, ``sigmas`` that in
    standard uncertainties. ``alternatives`` are other rows that may be the wrong one, with their probabilities.
    """

    row: int
    probability: float
    off: float
    sigmas: float
    alternatives: tuple[tuple[int, float], ...] = ()


@dataclass(frozen=True, slots=True)
class _HeldOut:
    off: float
    sigmas: float
    log_odds: float


@dataclass(frozen=True, slots=True, eq=False)
class _Poses:
    """Means ``accel`` (n, 3) [output] with standard uncertainty ``std``; ``gravity`` [g]."""

    accel: FloatArray
    std: FloatArray
    gravity: float
    is_std_stated: bool

    def held_out(self, without: Sequence[int]) -> dict[int, _HeldOut]:
        """Hold out each pose in turn where those ``without`` are gone; none whose others determine no fit."""
        inside = np.setdiff1d(np.arange(len(self.accel)), without)
        found = dict[int, _HeldOut]()
        for row in inside.tolist():
            others = inside[inside != row]
            fit = fit_norm(self.accel[others], self.std[others], self.gravity)
            if isinstance(fit, NormFit):
                found[row] = self._against(fit, row, others)
        return found

    def _against(self, fit: NormFit, row: int, others: IntArray) -> _HeldOut:
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
        gain = float(log_mean(right + odds.gain_of_squares((sigmas / scale) ** 2, 1)) - log_mean(right))
        return _HeldOut(off, float(abs(sigmas)), odds.log_odds(gain, len(self.accel)))


def find_wrong_poses(
    accel: FloatArray, std: FloatArray, gravity: float, *, is_std_stated: bool
) -> tuple[WrongPose, ...]:
    """Find the poses that contradict the others, as they are likelier than none.

    Parameters
    ----------
    accel, std : (n, 3) [output], means and their standard uncertainties
    gravity : [g], the specific force in every pose
    is_std_stated : whether ``std`` holds noise that was measured; else it is the least that noise may be
    """
    poses = _Poses(accel, std, gravity, is_std_stated)
    most = min(MOST_WRONG, int((1 - LEAST_RIGHT) * len(accel)))
    out, total, best, number = list[int](), 0.0, 0.0, 0
    while len(out) < most and (found := poses.held_out(out)):
        row = max(found, key=lambda each: found[each].log_odds)
        out, total = [*out, row], total + found[row].log_odds
        if total > best:
            best, number = total, len(out)
    wrong = out[:number]
    return tuple(_wrong_pose(poses, row, [each for each in wrong if each != row]) for row in wrong)


def _wrong_pose(poses: _Poses, row: int, others: Sequence[int]) -> WrongPose:
    """Return a pose with its share of the probability where the ``others`` that are wrong are held out."""
    found = poses.held_out(others)
    shares = odds.shares({str(each): one.log_odds for each, one in found.items()})
    likely = sorted(((int(name), share) for name, share in shares.items()), key=lambda each: -each[1])
    alternatives = tuple(each for each in likely if each[0] != row and each[1] >= priors.NEGLIGIBLE)
    return WrongPose(row, shares[str(row)], found[row].off, found[row].sigmas, alternatives)


def _predicted(fit: NormFit, mean: FloatArray, gravity: float) -> tuple[float, float]:
    """Return how far the norm of a pose with output ``mean`` (3,) is off gravity [g], and u of the fit in it."""
    u = np.linalg.solve(fit.K, mean - fit.b)
    length = float(np.linalg.norm(u))
    w = np.linalg.solve(fit.K.T, u / length)
    rows, columns = LOWER_TRIANGLE
    gradient = -np.concatenate((w[rows] * u[columns], w))
    return length - gravity, float(np.sqrt(gradient @ fit.fit.covariance @ gradient))
