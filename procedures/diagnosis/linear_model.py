"""A linear model of the evidence: what its parameters and some effects make of the residual, and how sure that is.

The residual of `procedures.diagnosis.residual_rows` is minimised over the model's parameters and the coefficients
c, which are held to nought by their plausible range. Each class of rows (means, shapes, turns, norms of a triad)
has a variance of its own: that of counting noise, unless the rows scatter by more than it can explain.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.diagnosis.residual_rows import KINDS, Evidence
from procedures.statistics.tail_probabilities import KNOWN_VARIANCE_DOF, log_chi2_sf, log_f_sf

MAX_WEIGHTINGS = 3  # of weighting anew
MIN_INFORMATION_SHARE = (
    0.1  # of a coefficient's information that a class must hold for its degrees of freedom to count
)
SINGULAR = 1e-12
MIN_EXPECTED_SIGMAS = (
    1.645  # sigmas by which a coefficient must be expected to stand for rows to say anything of it
)
WIDENED_LOG_P = np.log(0.05)  # ln p of a class's scatter, below which counting noise is not all of it
NORMS_WIDENED_LOG_P = np.log(1e-3)  # of it, below which norms need no means to bear them out
NORM_CLASS, MEAN_CLASS = 1 + KINDS.index("norm"), 1 + KINDS.index("mean")  # classes of the accelerometers


def variance_classes(evidence: Evidence) -> IntArray:
    """Return numbers (n,) of the rows that share a variance: by triad and kind, shapes as one; 0: known rows."""
    kind = np.where(evidence.kind == KINDS.index("curvature"), KINDS.index("slope"), evidence.kind)
    return np.where(evidence.kind == KINDS.index("prior"), 0, 1 + evidence.triad * len(KINDS) + kind)


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """Columns of an effect and how far its coefficients may plausibly be from nought (k,)."""

    H: FloatArray
    plausible: FloatArray


@dataclass(frozen=True, eq=False)
class LinearFit:
    """The minimum for one set of terms.

    ``theta`` holds the model's parameters dx (of the columns kept), then the coefficients of all terms in order;
    ``Q``, ``R`` factor the whitened design, prior rows of coefficients last; ``whole`` is the whitened residual
    left of all these rows, ``white`` (n,) that of the evidence; ``factor`` (n,) by how much each row's sigma was
    widened, ``dof`` that of each row's class.
    """

    theta: FloatArray
    Q: FloatArray
    R: FloatArray
    whole: FloatArray
    factor: FloatArray
    dof: FloatArray
    sizes: tuple[int, ...]

    @property
    def white(self) -> FloatArray:
        """The evidence's whitened residual (n,)."""
        return self.whole[: len(self.factor)]

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance (p, p) of theta."""
        root = np.linalg.inv(self.R)
        return root @ root.T

    def span(self, term: int) -> slice:
        """Where a term's coefficients stand in theta; negative numbers count from the last."""
        ends = np.cumsum([len(self.theta) - sum(self.sizes), *self.sizes])
        term %= len(self.sizes)
        return slice(int(ends[term]), int(ends[term + 1]))

    def coefficients(self, term: int = -1) -> tuple[FloatArray, FloatArray]:
        """Return a term's coefficients (k,) and their covariance (k, k)."""
        at = self.span(term)
        return self.theta[at], self.covariance[at, at]

    @property
    def leverage(self) -> FloatArray:
        """Share (n,) of each row's variance that the fit absorbs."""
        absorbed: FloatArray = np.sum(self.Q[: len(self.white)] ** 2, axis=1)
        return absorbed


def fit_linear(
    evidence: Evidence,
    terms: Sequence[Term],
    keep: BoolArray | None = None,
    factor: FloatArray | None = None,
    unwidened: LinearFit | None = None,
) -> LinearFit:
    """Fit the model's parameters (columns of A marked in ``keep`` (p,), else all) and the terms' coefficients.

    ``factor`` (n,) widens the rows' sigma by a given amount; else it is found, from ``unwidened`` on where the fit
    with a factor of 1 is known.
    """
    A = evidence.A if keep is None else evidence.A[:, keep]
    H = np.hstack([np.zeros((len(A), 0)), *(term.H for term in terms)])
    design = np.hstack((A, -H))
    prior = np.hstack((np.zeros((H.shape[1], A.shape[1])), np.diag(_inverse_ranges(terms))))
    shared, given = variance_classes(evidence), factor
    factor = np.ones(len(A)) if given is None else given
    dof = np.full(len(A), np.inf)
    for _ in range(MAX_WEIGHTINGS if given is None else 1):
        weight = 1 / (evidence.sigma * factor)
        if unwidened is None:
            Q, R = np.linalg.qr(np.vstack((design * weight[:, None], prior)))
            y = np.concatenate((evidence.residual * weight, np.zeros(len(prior))))
            theta = -np.linalg.solve(R, Q.T @ y)
            whole = y - Q @ (Q.T @ y)
        else:
            Q, R, theta, whole, unwidened = unwidened.Q, unwidened.R, unwidened.theta, unwidened.whole, None
        white = whole[: len(A)]
        if given is not None:
            break
        used = factor
        factor, dof = _widened(shared, white * factor, 1 - np.sum(Q[: len(A)] ** 2, axis=1))
        if np.array_equal(factor, used):
            break
    else:
        factor = used
    return LinearFit(theta, Q, R, whole, factor, dof, tuple(term.H.shape[1] for term in terms))


def _inverse_ranges(terms: Sequence[Term]) -> FloatArray:
    return 1 / np.concatenate([np.zeros(0), *(term.plausible for term in terms)])


def _widened(shared: IntArray, white: FloatArray, free: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factor on every row's sigma and the degrees of freedom behind it (infinite: noise is all).

    Norms of a few rests leave few degrees of freedom: by chance one campaign in twenty would be blind to what
    they alone show. What scatters them scatters the dwells' means as well, so between `WIDENED_LOG_P` and
    `NORMS_WIDENED_LOG_P` both must.
    """
    factor, dof = np.ones(len(white)), np.full(len(white), np.inf)
    for number in np.unique(shared[shared > 0]):
        rows = shared == number
        squares, left, log_p = _scatter(rows, white, free)
        if number == NORM_CLASS and log_p > NORMS_WIDENED_LOG_P:
            log_p = max(log_p, _scatter(shared == MEAN_CLASS, white, free)[2])
        if squares > left and log_p < WIDENED_LOG_P:
            factor[rows], dof[rows] = np.sqrt(squares / left), left
    return factor, dof


def _scatter(rows: BoolArray, white: FloatArray, free: FloatArray) -> tuple[float, float, float]:
    """Return rows' sum of squares, their degrees of freedom, and ln p of the one by the other."""
    squares, left = float(np.sum(white[rows] ** 2)), max(float(np.sum(free[rows])), 1.0)
    return squares, left, log_chi2_sf(squares, max(round(left), 1))


def coefficients_beside(evidence: Evidence, fit: LinearFit, other: Term) -> tuple[FloatArray, FloatArray]:
    """Return what the last term's coefficients (k,) and their covariance would be with another term beside it.

    The other's columns, as far as the fit leaves them, are all that it adds; the rows' sigmas stay.
    """
    W = np.zeros((len(fit.Q), other.H.shape[1]))
    W[: len(fit.white)] = -other.H / (evidence.sigma * fit.factor)[:, None]
    taken = fit.Q.T @ W
    left = W - fit.Q @ taken
    information = left.T @ left + np.diag(1 / other.plausible**2)
    G = np.linalg.solve(fit.R, taken)[fit.span(-1)]
    c, C = fit.coefficients()
    return c + G @ np.linalg.solve(information, left.T @ fit.whole), C + G @ np.linalg.solve(information, G.T)


@dataclass(frozen=True, slots=True, eq=False)
class Significance:
    """ln p of a term: jointly, and of its best single coefficient, both counted; coefficients, sigmas, dof."""

    log_p: float
    statistic: float
    value: FloatArray
    std: FloatArray
    dof: float


def significance(evidence: Evidence, fit: LinearFit, term: int = -1) -> Significance:
    """Test whether a term's coefficients are all nought.

    An effect may act on one sensor or on all: the smaller of the joint p and the least single one times their
    number is taken, twice, since two were tried.
    """
    c, C = fit.coefficients(term)
    dof = _dof(evidence, fit, term)
    k = len(c)
    joint = float(c @ np.linalg.solve(C, c))
    std = np.sqrt(np.diag(C))
    log_p = log_f_sf(joint / k, k, dof)
    if k > 1:
        single = log_f_sf(float(np.max((c / std) ** 2)), 1, dof) + np.log(k)
        log_p = min(log_p, single) + np.log(2)
    return Significance(min(log_p, 0.0), joint / k, c, std, dof)


def borne_out(told: Significance, again: Significance) -> float:
    """Return by how many sigmas the best coefficient, seen by fewer rows, exceeds what chance would leave of it.

    Of a value c with 1 sigma s, fewer rows leave c' with s', and c' - c scatters by sqrt(s'^2 - s^2) [sigma]
    (Hausman 1978); what they could not tell, c < `MIN_EXPECTED_SIGMAS` s', is borne out by nothing.
    """
    i = int(np.argmax(np.abs(told.value / told.std)))
    c, left = float(abs(told.value[i])), float(again.value[i] * np.sign(told.value[i]))
    if c < MIN_EXPECTED_SIGMAS * again.std[i]:
        return -np.inf
    return (left - c) / float(np.sqrt(max(again.std[i] ** 2 - told.std[i] ** 2, SINGULAR * c**2)))


def _dof(evidence: Evidence, fit: LinearFit, term: int) -> float:
    """Return the least degrees of freedom behind the variances of the rows that tell most of a term."""
    at = fit.span(term)
    Q, n = fit.Q[:, : at.stop], len(fit.white)
    told = np.sum(Q[:n, at] ** 2, axis=1)  # share of the term's own information by row
    shared, found = variance_classes(evidence), KNOWN_VARIANCE_DOF * 10
    for number in np.unique(shared[shared > 0]):
        rows = shared == number
        if told[rows].sum() > MIN_INFORMATION_SHARE * told.sum():
            found = min(found, float(fit.dof[rows][0]))
    return found


def predict_left_out(evidence: Evidence, fit: LinearFit, groups: Sequence[IntArray]) -> tuple[float, FloatArray]:
    """Return the log predictive density of all groups, each left out in turn, and the errors (n,) made, in sigmas.

    With L the group's block of the hat matrix, what is left out is off by ``(I - L)^-1 e`` and known to
    ``(I - L)^-1``, both whitened: no fit is repeated, and what a campaign cannot foretell is not held against a
    model. Rows in no group, and errors known to worse than ten sigmas, are nan.
    """
    total, errors = 0.0, np.full(len(fit.white), np.nan)
    for rows in groups:
        e, Q = fit.white[rows], fit.Q[rows]
        values, vectors = np.linalg.eigh(np.eye(len(rows)) - Q @ Q.T)
        values = np.maximum(values, SINGULAR)
        turned = vectors.T @ e
        total += -0.5 * float(np.sum(turned**2 / values - np.log(values)))
        spread = np.sum(vectors**2 / values, axis=1)
        errors[rows] = np.where(spread < 100, vectors @ (turned / values), np.nan)
    return total, errors


def without_rows(fit: LinearFit, rows: IntArray) -> LinearFit:
    """Return a fit without some rows, their numbers (r,), dimensionless: its normal equations less theirs."""
    keep = np.ones(len(fit.Q), dtype=bool)
    keep[rows] = False
    design = fit.Q[keep]
    Q, R = np.linalg.qr(design)
    step = np.linalg.solve(R @ fit.R, Q.T @ fit.whole[keep])
    return replace(fit, Q=_spread(Q, keep), R=R @ fit.R, theta=fit.theta - step)


def _spread(Q: FloatArray, keep: BoolArray) -> FloatArray:
    wide = np.zeros((len(keep), Q.shape[1]))
    wide[keep] = Q
    return wide
