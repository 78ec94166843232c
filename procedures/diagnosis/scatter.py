"""Scatter as an effect: columns of one coefficient a step, all of them draws of one variance, which is fitted.

With the model and other terms fitted, what is left of the whitened residual is r, of the columns, each times its
plausible size, W = U S V'. A scatter of s times the plausible size gives U'r the variance 1 + s^2 S^2, so that the
marginal likelihood (all coefficients integrated out: REML, Patterson and Thompson 1971) gains

    L(s) = -1/2 sum [ln(1 + s^2 S^2) - (U'r)^2 s^2 S^2 / (1 + s^2 S^2)]

over no scatter. 2 L at its maximum is half chi-square of 0, half of 1 degree of freedom (Self and Liang 1987). The
same L measures what any other effect explains, its size unknown up to what is plausible: what explains as much as
a scatter cannot be told from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.linear_model import LinearFit, Significance, Term, significance, variance_classes
from procedures.diagnosis.residual_rows import Evidence
from procedures.statistics.least_squares import left_singular
from procedures.statistics.significance import KNOWN_VARIANCE_DOF, log_chi2_sf

SIZES = np.geomspace(1e-3, 1e2, 401)  # times the plausible size
FAMILY_SIGMAS = np.geomspace(1, 1e3, 61)  # that a curve does to all rows together
MAX_SIZE = 10.0  # times: above, a scatter is not believed
MIN_MARGIN = float(np.log(20))  # of marginal likelihood, below which two explanations are not told apart
MIN_INFORMATION_SHARE = 0.1  # of what tells the columns, that a class of rows must hold to be its rival


@dataclass(frozen=True, slots=True, eq=False)
class FittedScatter:
    """A scatter: ``times`` its plausible size with 1 sigma ``std``, and its ``gain`` of ln marginal likelihood."""

    candidate: Candidate
    times: float
    std: float
    gain: float

    @property
    def is_believed(self) -> bool:
        """Say whether it is of a plausible size."""
        return self.times <= MAX_SIZE

    @property
    def test(self) -> Significance:
        """Its test."""
        log_p = log_chi2_sf(2 * self.gain, 1) - np.log(2)
        size, std = (x * self.candidate.term.plausible / self.times for x in (self.times, self.std))
        return Significance(min(float(log_p), 0.0), 2 * self.gain, size, std, KNOWN_VARIANCE_DOF * 10.0)


def fitted_scatter(evidence: Evidence, candidate: Candidate, others: Sequence[Term]) -> FittedScatter | None:
    """Return the size of a scatter beside the model and other terms; None where it explains nothing of its own.

    Where the rows that tell it merely scatter more than their noise, all of them, it is no matter of the columns.
    """
    plausible = candidate.effect.plausible_of(candidate.columns)
    before = candidate.without(evidence, others, np.ones(len(evidence.residual)))
    size, z = _seen(evidence, before, candidate.term.H * plausible)
    gains = _gains(size, z, SIZES)
    best = int(np.argmax(gains))
    if gains[best] <= _gain_of_noise(evidence, before, candidate.term.H * plausible):
        return None
    times = float(SIZES[best])
    told = (times * size) ** 2 / (1 + (times * size) ** 2)
    std = times / np.sqrt(2 * float(np.sum(told**2)))  # by the information of ln s
    fitted = replace(candidate, term=Term(candidate.term.H, times * plausible))
    return FittedScatter(fitted, times, std, float(gains[best]))


def marginal_gain(evidence: Evidence, candidate: Candidate, others: Sequence[Term]) -> float:
    """Return the gain of ln marginal likelihood by an effect, all its coefficients or the best one alone.

    Its size is unknown up to what is plausible; a scatter is taken as it was fitted. Of several coefficients that
    one alone is there counts as often as there are such.
    """
    before = candidate.without(evidence, others, np.ones(len(evidence.residual)))
    H = candidate.term.H * candidate.term.plausible
    if candidate.effect.is_scatter:
        return float(_gains(*_seen(evidence, before, H), np.ones(1))[0])
    sizes = SIZES[SIZES <= 1]
    ways = [H, *(H[:, i : i + 1] for i in range(H.shape[1]) if H.shape[1] > 1)]
    gains = [float(np.max(_gains(*_seen(evidence, before, each), sizes))) for each in ways]
    best_alone = max(gains[1:], default=-np.inf) - float(np.log(max(len(gains) - 1, 1)))
    return max(gains[0], best_alone)


def likeliest_gain(evidence: Evidence, before: LinearFit, H: FloatArray) -> float:
    """Return the gain of ln marginal likelihood by columns H (n, k) whose coefficients have one variance.

    H is such that a unit does 1 sigma [g, deg/h, deg]; the variance is what gains most.
    """
    return likeliest(evidence, before, H)[1]


def likeliest(evidence: Evidence, before: LinearFit, H: FloatArray) -> tuple[float, float]:
    """Return the 1 sigma that coefficients of columns H (n, k) likeliest have, and its gain [ln likelihood].

    H is as of `likeliest_gain`.
    """
    gains = _gains(*_seen(evidence, before, H), FAMILY_SIGMAS)
    return float(FAMILY_SIGMAS[np.argmax(gains)]), float(np.max(gains))


def tested(evidence: Evidence, candidate: Candidate, others: Sequence[Term]) -> Significance:
    """Test a candidate that is in the model beside other terms, a scatter by its variance."""
    if not candidate.effect.is_scatter:
        return significance(evidence, candidate.fit(evidence, others))
    found = fitted_scatter(evidence, candidate, others)
    zero = np.zeros(len(candidate.term.plausible))
    return Significance(0.0, 0.0, zero, zero, np.inf) if found is None else found.test


def _seen(evidence: Evidence, before: LinearFit, H: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how well each combination of columns H (n, k) is seen (k,), and what is left along it (k,)."""
    W = np.zeros((len(before.Q), H.shape[1]))
    W[: len(H)] = H / evidence.sigma[:, None]
    U, size = left_singular(W - before.Q @ (before.Q.T @ W))
    return size, U.T @ before.whole


def _gains(size: FloatArray, z: FloatArray, times: FloatArray) -> FloatArray:
    """Return the gain of ln marginal likelihood (m,) at each of ``times`` (m,)."""
    variance = (times[:, None] * size) ** 2
    gains: FloatArray = -0.5 * np.sum(np.log1p(variance) - z**2 * variance / (1 + variance), axis=1)
    return gains


def _gain_of_noise(evidence: Evidence, before: LinearFit, H: FloatArray) -> float:
    """Return what is gained where the classes of rows that tell H (n, k) have a wider noise instead."""
    shared, told = variance_classes(evidence), np.sum((H / evidence.sigma[:, None]) ** 2, axis=1)
    gain = 0.0
    for number in np.unique(shared[shared > 0]):
        rows = shared == number
        if told[rows].sum() > MIN_INFORMATION_SHARE * told.sum():
            squares, free = float(np.sum(before.white[rows] ** 2)), float(np.sum((1 - before.leverage)[rows]))
            if squares > free > 0:
                gain += 0.5 * (squares - free - free * np.log(squares / free))
    return gain
