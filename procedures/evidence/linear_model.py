"""A linear model of the evidence: what its parameters and some effects make of the residual, and how sure that is.

The residual of `procedures.evidence.residual_rows` is minimised over the model's parameters and the coefficients
c, which are held to zero by their plausible range. Each class of rows (means, shapes, turns, norms of a triad)
has a variance of its own: that of counting noise, unless the rows scatter by more than it can explain.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg.lapack import dtrtri, dtrtrs

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.statistics.significance import log_chi2_sf

MAX_WEIGHTINGS = 3  # of weighting again
SINGULAR = 1e-12
SAYS_NOTHING = "the rows say nothing of some unknown"
MOST_BY_NORMAL_EQUATIONS = 1e4  # of the largest weight over the least: its square takes half of the digits
WIDENED_LOG_P = np.log(0.05)  # ln p of a class's scatter, below which counting noise is not all of it
NORMS_WIDENED_LOG_P = np.log(1e-3)  # of it, below which norms need no means to bear them out
KNOWN = (KINDS.index("prior"), KINDS.index("level"))  # kinds of rows whose variance is not fitted
NORM_CLASS, MEAN_CLASS = 1 + KINDS.index("norm"), 1 + KINDS.index("mean")  # classes of the accelerometers


@lru_cache(maxsize=8)
def variance_classes(evidence: Evidence) -> IntArray:
    """Return numbers (n,) of the rows that share a variance: by triad and kind, shapes as one; 0: known rows.

    Known is what was stated, and how far attitudes nobody stated may move the levels of soaks.
    """
    kind = np.where(evidence.kind == KINDS.index("curvature"), KINDS.index("slope"), evidence.kind)
    return np.where(np.isin(evidence.kind, KNOWN), 0, 1 + evidence.triad * len(KINDS) + kind)


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """Columns of an effect and how far its coefficients may plausibly be from zero (k,)."""

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
    def root(self) -> FloatArray:
        """The inverse (p, p) of R, a root of the covariance."""
        return triangular_inverse(self.R)

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance (p, p) of theta."""
        return self.root @ self.root.T

    def span(self, term: int) -> slice:
        """Where a term's coefficients stand in theta; negative numbers count from the last."""
        end = len(self.theta) - sum(self.sizes[term % len(self.sizes) + 1 :])
        return slice(end - self.sizes[term], end)

    def coefficients(self, term: int = -1) -> tuple[FloatArray, FloatArray]:
        """Return a term's coefficients (k,) and their covariance (k, k)."""
        at = self.span(term)
        root = triangular_inverse(self.R[at.start :, at.start :])[: at.stop - at.start]
        return self.theta[at], root @ root.T

    @property
    def leverage(self) -> FloatArray:
        """Share (n,) of each row's variance that the fit absorbs."""
        Q = self.Q[: len(self.factor)]
        absorbed: FloatArray = np.vecdot(Q, Q)
        return absorbed


def fit_linear(
    evidence: Evidence,
    terms: Sequence[Term],
    keep: BoolArray | None = None,
    factor: FloatArray | None = None,
) -> LinearFit:
    """Fit the model's parameters (columns of A marked in ``keep`` (p,), else all) and the terms' coefficients.

    ``factor`` (n,) widens the rows' sigma by a given amount; else it is found.
    """
    kept = None if keep is None or keep.all() else keep.tobytes()
    return fitted(evidence, tuple(terms), kept, None if factor is None else factor.tobytes())


@lru_cache(maxsize=32)
def fitted(evidence: Evidence, terms: tuple[Term, ...], keep: bytes | None, widened_by: bytes | None) -> LinearFit:
    """Return the fit of `fit_linear`, which one check after another asks for; arrays are given as bytes."""
    first = _with_terms(evidence, terms, keep)
    if widened_by is not None:
        return _reweighted(first, np.frombuffer(widened_by))
    shared, fit = variance_classes(evidence), first
    for _ in range(MAX_WEIGHTINGS - 1):
        factor, dof = _widened(shared, fit.white * fit.factor, 1 - fit.leverage)
        if np.array_equal(factor, fit.factor):
            break
        fit = _reweighted(first, factor)
    else:
        _, dof = _widened(shared, fit.white * fit.factor, 1 - fit.leverage)
    return replace(fit, dof=dof)


def _with_terms(evidence: Evidence, terms: tuple[Term, ...], keep: bytes | None) -> LinearFit:
    """Fit with the rows' own sigma; model and terms are factored once for all that may stand last.

    ``keep`` are the marks of A's columns as bytes.
    """
    if terms:
        return _with_one_more(evidence, fit_with(evidence, terms[:-1], keep), terms[-1])
    A = evidence.A if keep is None else evidence.A[:, np.frombuffer(keep, dtype=bool)]
    Q, R = np.linalg.qr(A / evidence.sigma[:, None])
    y = evidence.residual / evidence.sigma
    along = Q.T @ y
    n = len(A)
    return LinearFit(-np.linalg.solve(R, along), Q, R, y - Q @ along, np.ones(n), np.full(n, np.inf), ())


@lru_cache(maxsize=8)
def fit_with(evidence: Evidence, terms: tuple[Term, ...], keep: bytes | None) -> LinearFit:
    """Return the fit of what many terms are tried with; ``keep`` are the marks of A's columns as bytes."""
    return _with_terms(evidence, terms, keep)


def _with_one_more(evidence: Evidence, fit: LinearFit, term: Term) -> LinearFit:
    """Return a fit with one more term."""
    (before, p), k = fit.Q.shape, term.H.shape[1]
    taken, q, r = orthogonal(evidence, fit, term)
    Q, R, whole = np.zeros((before + k, p + k)), np.zeros((p + k, p + k)), np.zeros(before + k)
    Q[:before, :p], Q[:, p:] = fit.Q, q
    R[:p, :p], R[:p, p:], R[p:, p:] = fit.R, taken, r
    whole[:before] = fit.whole
    along = q.T @ whole
    c = -np.linalg.solve(r, along)
    theta = np.concatenate((fit.theta - fit.root @ (taken @ c), c))
    return LinearFit(theta, Q, R, whole - q @ along, fit.factor, fit.dof, (*fit.sizes, k))


def orthogonal(evidence: Evidence, fit: LinearFit, term: Term) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Make a term's whitened columns orthogonal to a fit's, those of m rows (Gram and Schmidt, twice).

    Return what of the fit's columns they are (p, k), and ``q`` (m + k, k), ``r`` (k, k) of what they add.
    """
    n, (before, p), k = len(fit.factor), fit.Q.shape, term.H.shape[1]
    added = np.zeros((before + k, k))
    added[:n] = -term.H / evidence.sigma[:, None]
    added[before:] = np.diag(1 / term.plausible)
    taken = np.zeros((p, k))
    for _ in range(2):
        more = fit.Q.T @ added[:before]
        added[:before] -= fit.Q @ more
        taken += more
    q, r = np.linalg.qr(added)
    return taken, q, r


def _reweighted(first: LinearFit, factor: FloatArray) -> LinearFit:
    """Return a fit, whose rows' sigmas are their own, with these ``factor`` (n,) times as large.

    With D the weights, ``D Q = (D Q L'^-1) L'`` where ``L L' = Q' D^2 Q``, whose condition is at most that of D^2;
    where that takes too many digits, D Q is factored itself.
    """
    if np.all(factor == 1):
        return first
    D = np.ones(len(first.Q))
    D[: len(factor)] = 1 / factor
    weighted, y = first.Q * D[:, None], first.whole * D
    if not len(first.R):  # no parameters, which LAPACK takes for a mistake
        return replace(first, Q=weighted, whole=y, factor=factor)
    Q: FloatArray
    if D.max() > MOST_BY_NORMAL_EQUATIONS * D.min():
        Q, r = np.linalg.qr(weighted)
    else:
        r = np.asarray(np.linalg.cholesky(weighted.T @ weighted).T, np.float64)
        Q = weighted @ triangular_inverse(r)
    R, along = r @ first.R, Q.T @ y
    step, singular = dtrtrs(R, along)
    if singular:
        raise np.linalg.LinAlgError(SAYS_NOTHING)
    theta = first.theta - step
    return replace(first, theta=theta, Q=Q, R=R, whole=y - Q @ along, factor=factor)


def triangular_inverse(R: FloatArray) -> FloatArray:
    """Return the inverse (p, p) of ``R`` (p, p), of any unit, which is zero below its diagonal."""
    if not len(R):
        return R
    inverse, singular = dtrtri(R)
    if singular:
        raise np.linalg.LinAlgError(SAYS_NOTHING)
    found: FloatArray = inverse
    return found


def _widened(shared: IntArray, white: FloatArray, free: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factor on every row's sigma and the degrees of freedom behind it (infinite: noise is all)."""
    factor, dof = widening(summed_by_class(shared, white**2), summed_by_class(shared, free))
    return factor[shared], dof[shared]


def summed_by_class(shared: IntArray, values: FloatArray) -> FloatArray:
    """Return the sum (c,) of rows' values (n,) over each class, ``shared`` (n,) its number."""
    total: FloatArray = np.asarray(np.bincount(shared, values), np.float64)
    return total


def widening(squares: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return each class's factor on its rows' sigma and the degrees of freedom behind it (infinite: noise is all).

    Norms of a few rests leave few degrees of freedom: by chance one campaign in twenty would be blind to what
    they alone show. What scatters them scatters the dwells' means as well, so between `WIDENED_LOG_P` and
    `NORMS_WIDENED_LOG_P` both must.

    Parameters
    ----------
    squares, left : (c,), the sum of each class's squares, in variances, and the degrees of freedom left it
    """
    factor, dof, left = np.ones(len(squares)), np.full(len(squares), np.inf), np.maximum(left, 1.0)

    def log_p(number: int) -> float:
        return log_chi2_sf(float(squares[number]), max(round(float(left[number])), 1))

    for number in (1 + np.flatnonzero(squares[1:] > left[1:])).tolist():
        p = log_p(number)
        if number == NORM_CLASS and p > NORMS_WIDENED_LOG_P:
            p = max(p, log_p(MEAN_CLASS))
        if p < WIDENED_LOG_P:
            factor[number], dof[number] = np.sqrt(squares[number] / left[number]), left[number]
    return factor, dof


def predict_left_out(evidence: Evidence, fit: LinearFit, groups: Sequence[IntArray]) -> tuple[float, FloatArray]:
    """Return the log predictive density of all groups, each left out in turn, and the errors (n,) made, in sigmas.

    With L the group's block of the hat matrix, what is left out is off by ``(I - L)^-1 e`` and known to
    ``(I - L)^-1``, both whitened: no fit is repeated, and what a campaign cannot predict is not held against a
    model. Rows in no group, and errors known to worse than ten sigmas, are nan.
    """
    total, errors = 0.0, np.full(len(fit.white), np.nan)
    for size in {len(rows) for rows in groups}:
        rows = np.array([each for each in groups if len(each) == size])  # (g, size)
        e, Q = fit.white[rows], fit.Q[rows]
        values, vectors = np.linalg.eigh(np.eye(size) - Q @ np.swapaxes(Q, 1, 2))
        values = np.maximum(values, SINGULAR)
        turned = np.einsum("gji,gj->gi", vectors, e)
        total += -0.5 * float(np.sum(turned**2 / values - np.log(values)))
        spread = np.sum(vectors**2 / values[:, None], axis=2)
        errors[rows] = np.where(spread < 100, np.einsum("gij,gj->gi", vectors, turned / values), np.nan)
    return total, errors
