"""A term tried beside a fit that many others are tried beside, by sums over the classes of rows.

What `linear_model.fit_linear` and `significance` say of it, without its fit. Rows of one class share their factor,
so with Q0 the fit's and q the term's orthonormal columns, w = 1 / factor^2,

    G = Q' diag(w) Q,   its part of Q0 alone being the sum over classes of w_c Q0_c' Q0_c,

of which the sums are made once for all terms. G's Cholesky factor L takes Q's columns to those of the weighted
fit, ``diag(sqrt(w)) Q L'^-1``, which are never made.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs, dtrtrs

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.linear_model import (
    MAX_WEIGHTINGS,
    MIN_INFORMATION_SHARE,
    MOST_BY_NORMAL_EQUATIONS,
    LinearFit,
    Significance,
    Term,
    fit_beside,
    fit_linear,
    orthogonal,
    significance,
    significance_of,
    summed_by_class,
    triangular_inverse,
    variance_classes,
    widening,
)
from procedures.diagnosis.residual_rows import Evidence
from procedures.statistics.tail_probabilities import KNOWN_VARIANCE_DOF


@dataclass(frozen=True, slots=True, eq=False)
class ClassSums:
    """Of a fit's columns Q0 (m, p) and what it leaves: ``square`` (c, p p) and ``pull`` (c, p) of each class.

    ``rows`` (c,) is how many of the evidence's each class has; rows that hold coefficients are of class 0, as is
    what is known. ``absorbed`` (n,) is each row's leverage.
    """

    shared: IntArray
    rows: FloatArray
    square: FloatArray
    pull: FloatArray
    absorbed: FloatArray


@lru_cache(maxsize=8)
def class_sums(evidence: Evidence, fit: LinearFit) -> ClassSums:
    """Return a fit's sums over the classes of the evidence's rows."""
    shared = variance_classes(evidence)
    every = np.concatenate((shared, np.zeros(len(fit.Q) - len(shared), dtype=shared.dtype)))
    square, pull = [], []
    for number in range(int(shared.max()) + 1):
        Q = fit.Q[every == number]
        square.append((Q.T @ Q).ravel())
        pull.append(Q.T @ fit.whole[every == number])
    rows = np.bincount(shared).astype(np.float64)
    return ClassSums(shared, rows, np.array(square), np.array(pull), fit.leverage)


def tried_term(evidence: Evidence, others: tuple[Term, ...], term: Term) -> Significance | None:
    """Return the test of a term beside the model and others; None where the model leaves too little of it to see.

    That is where 1 sigma of each coefficient, by the rows' own, is no less than half its plausible size.
    """
    fit = fit_beside(evidence, others, None)
    _, q, r = orthogonal(evidence, fit, term)
    root = triangular_inverse(r)
    if not np.any(np.sqrt(np.vecdot(root, root)) < 0.5 * term.plausible):
        return None
    trial = _Trial(class_sums(evidence, fit), fit, q, r, root)
    if trial.settle():
        return significance_of(trial.c, trial.root @ trial.root.T, trial.least_dof())
    return significance(evidence, fit_linear(evidence, [*others, term]))


class _Trial:
    """A term's coefficients ``c`` (k,), a ``root`` (k, k) of their covariance, and each class's ``factor`` (c,).

    ``q`` (m + k, k) are its orthonormal columns, its own priors last.
    """

    def __init__(self, sums: ClassSums, fit: LinearFit, q: FloatArray, r: FloatArray, root: FloatArray) -> None:
        self.sums, self.fit, self.q, self.r, self.root = sums, fit, q, r, root
        self.n, self.m, self.k = len(sums.shared), len(fit.Q), q.shape[1]
        self.along = q[: self.m].T @ fit.whole
        self.whole, self.priors = fit.whole - q[: self.m] @ self.along, -q[self.m :] @ self.along
        self.first, self.c = root, -root @ self.along
        self.factor, self.dof = np.ones(len(sums.rows)), np.full(len(sums.rows), np.inf)
        self.last: tuple[FloatArray, FloatArray] | None = None  # of L'^-1, the term's columns: of Q0 and of q

    def settle(self) -> bool:
        """Weigh the classes anew until their factors stay; False where that takes too many digits."""
        white, left = self.whole[: self.n], self._left_at_first()
        for _ in range(MAX_WEIGHTINGS - 1):
            factor, self.dof = self._widened(white, left)
            if np.array_equal(factor, self.factor):
                return True
            if factor.max() > MOST_BY_NORMAL_EQUATIONS:
                return False
            white, left = self._weigh(factor)
        _, self.dof = self._widened(white, left)
        return True

    def _widened(self, white: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray]:
        return widening(summed_by_class(self.sums.shared, white**2), left)

    def _left_at_first(self) -> FloatArray:
        """Return the degrees of freedom (c,) that the fit with the rows' own sigma leaves each class."""
        q = self.q[: self.n]
        absorbed = self.sums.absorbed + np.vecdot(q, q)
        return self.sums.rows - summed_by_class(self.sums.shared, absorbed)

    def _weigh(self, factor: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fit with these factors (c,): return what is left (n,), in rows' own sigmas, and the free rows (c,)."""
        self.factor, weight = factor, factor**-2
        by_row = np.ones(self.m)
        by_row[: self.n] = weight[self.sums.shared]
        Q, q, priors, p = self.fit.Q, self.q[: self.m], self.q[self.m :], self.fit.Q.shape[1]
        weighted = by_row[:, None] * q
        G, h = np.empty((p + self.k, p + self.k)), np.empty(p + self.k)
        G[:p, :p] = (weight @ self.sums.square).reshape(p, p)
        G[:p, p:] = Q.T @ weighted
        G[p:, :p], G[p:, p:] = G[:p, p:].T, q.T @ weighted + priors.T @ priors
        h[:p] = weight @ self.sums.pull - G[:p, p:] @ self.along
        h[p:] = weighted.T @ self.whole + priors.T @ self.priors
        L, failed = dpotrf(G, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the weighted rows say nothing of some unknown")
        g, _ = dpotrs(L, h, lower=1)
        self.root = triangular_inverse(L[p:, p:].T @ self.r)
        self.c = -self.first @ (self.along + g[p:])
        last, _ = dtrtrs(L, np.eye(p + self.k)[:, p:], lower=1, trans=1)
        self.last = last[:p], last[p:]
        inverse, _ = dpotri(L, lower=1)
        inverse = inverse + inverse.T  # LAPACK makes the lower half; the upper one is nought
        inverse.flat[:: p + self.k + 1] *= 0.5
        own = 2 * Q[: self.n] @ inverse[:p, p:] + q[: self.n] @ inverse[p:, p:]
        shares = self.sums.square @ inverse[:p, :p].ravel()
        shares += summed_by_class(self.sums.shared, np.vecdot(own, q[: self.n]))
        return (self.whole - Q @ g[:p] - q @ g[p:])[: self.n], self.sums.rows - weight * shares

    def least_dof(self) -> float:
        """Return the least degrees of freedom behind the classes that tell most of the term."""
        told = self.q[: self.n]
        if self.last is not None:
            told = self.fit.Q[: self.n] @ self.last[0] + told @ self.last[1]
            told = told / self.factor[self.sums.shared][:, None]
        by_class = summed_by_class(self.sums.shared, np.vecdot(told, told))
        telling = by_class[1:] > MIN_INFORMATION_SHARE * by_class.sum()
        return float(min(KNOWN_VARIANCE_DOF * 10, self.dof[1:][telling].min(initial=np.inf)))
