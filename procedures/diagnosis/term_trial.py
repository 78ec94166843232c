"""A term tried beside a fit that many others are tried beside, by sums over the classes of rows.

What `linear_model.fit_linear` and `significance` say of it, without its fit. Rows of one class share their factor,
so with Q0 the fit's and q the term's orthonormal columns, w = 1 / factor^2,

    G = Q' diag(w) Q = I + the sum over the classes that are widened of (w_c - 1) Q_c' Q_c,

with Q_c the rows of a class, of which the parts of Q0 alone are made once for all terms. Where one class is
widened, the eigenvectors of its part make G0 diagonal, whatever w is. With ``E = G0^-1 Q0' diag(w) q`` and M what
Q0 leaves of q, ``M = q' diag(w) q - E' G0 E = L L'``, the term's columns in the weighted fit are

    diag(sqrt(w)) (q - Q0 E) L'^-1
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs

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
from procedures.statistics.significance import KNOWN_VARIANCE_DOF


@dataclass(frozen=True, slots=True, eq=False)
class ClassSums:
    """Of a fit's columns Q0 (m, p) and what it leaves: ``square`` (c, p p) and ``pull`` (c, p) of each class.

    ``rows`` (c,) is how many of the evidence's each class has; rows that hold coefficients are of class 0, as is
    what is known. ``of_class`` are the rows' numbers of each, ``absorbed`` (n,) is each row's leverage.
    """

    shared: IntArray
    rows: FloatArray
    of_class: tuple[IntArray, ...]
    square: FloatArray
    pull: FloatArray
    absorbed: FloatArray


@lru_cache(maxsize=8)
def class_sums(evidence: Evidence, fit: LinearFit) -> ClassSums:
    """Return a fit's sums over the classes of the evidence's rows."""
    shared = variance_classes(evidence)
    every = np.concatenate((shared, np.zeros(len(fit.Q) - len(shared), dtype=shared.dtype)))
    square, pull, of_class = [], [], []
    for number in range(int(shared.max()) + 1):
        of_class.append(here := np.flatnonzero(every == number))
        Q = fit.Q[here]
        square.append((Q.T @ Q).ravel())
        pull.append(Q.T @ fit.whole[here])
    rows = np.bincount(shared).astype(np.float64)
    return ClassSums(shared, rows, tuple(of_class), np.array(square), np.array(pull), fit.leverage)


@dataclass(frozen=True, slots=True, eq=False)
class OneWidened:
    """A fit's columns turned by the eigenvectors of one class's part, ``Q`` (m, p), its ``values`` (p,).

    ``diagonal`` (c, p) is that of every class's part, so turned, and ``pull`` (p,) that class's.
    """

    Q: FloatArray
    values: FloatArray
    diagonal: FloatArray
    pull: FloatArray


@lru_cache(maxsize=32)
def one_widened(evidence: Evidence, fit: LinearFit, number: int) -> OneWidened:
    """Return a fit's columns where class ``number`` alone is widened."""
    sums, p = class_sums(evidence, fit), fit.Q.shape[1]
    values, vectors = np.linalg.eigh(sums.square[number].reshape(p, p))
    Q = fit.Q @ vectors
    diagonal = np.array([np.sum(Q[here] ** 2, axis=0) for here in sums.of_class])
    return OneWidened(Q, values, diagonal, sums.pull[number] @ vectors)


@lru_cache(maxsize=4096)  # all ways of all effects, where a loop stands and where it stood
def tried_term(evidence: Evidence, others: tuple[Term, ...], term: Term) -> Significance | None:
    """Return the test of a term beside the model and others; None where the model leaves too little of it to see.

    That is where 1 sigma of each coefficient, by the rows' own, is no less than half its plausible size.
    """
    fit = fit_beside(evidence, others, None)
    _, q, r = orthogonal(evidence, fit, term)
    root = triangular_inverse(r)
    if not np.any(np.sqrt(np.vecdot(root, root)) < 0.5 * term.plausible):
        return None
    trial = _Trial(evidence, fit, q, r, root)
    if trial.settle():
        return significance_of(trial.c, trial.root @ trial.root.T, trial.least_dof())
    return significance(evidence, fit_linear(evidence, [*others, term]))


class _Trial:
    """A term's coefficients ``c`` (k,), a ``root`` (k, k) of their covariance, and each class's ``factor`` (c,).

    ``q`` (m + k, k) are its orthonormal columns, its own priors last.
    """

    def __init__(self, evidence: Evidence, fit: LinearFit, q: FloatArray, r: FloatArray, root: FloatArray) -> None:
        self.evidence, self.sums = evidence, class_sums(evidence, fit)
        self.fit, self.q, self.r, self.root = fit, q, r, root
        self.n, self.m, self.k = len(self.sums.shared), len(fit.Q), q.shape[1]
        self.along = q[: self.m].T @ fit.whole
        self.whole = fit.whole - q[: self.m] @ self.along
        self.first, self.c = root, -root @ self.along
        self.factor, self.dof = np.ones(len(self.sums.rows)), np.full(len(self.sums.rows), np.inf)
        self.told = q[: self.n]  # its columns in the weighted fit, in rows' own sigmas

    def settle(self) -> bool:
        """Weigh the classes anew until their factors stay; False where that takes too many digits."""
        white = self.whole[: self.n]
        left = self.sums.rows - self._summed(self.sums.absorbed + np.vecdot(self.told, self.told))
        for _ in range(MAX_WEIGHTINGS - 1):
            factor, self.dof = self._widened(white, left)
            if np.array_equal(factor, self.factor):
                return True
            if factor.max() > MOST_BY_NORMAL_EQUATIONS:
                return False
            white, left = self._weigh(factor)
        _, self.dof = self._widened(white, left)
        return True

    def _summed(self, by_row: FloatArray) -> FloatArray:
        return summed_by_class(self.sums.shared, by_row)

    def _widened(self, white: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray]:
        return widening(self._summed(white**2), left)

    def _weigh(self, factor: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fit with these factors (c,): return what is left (n,), in rows' own sigmas, and the free rows (c,)."""
        self.factor, weight = factor, factor**-2
        widened = np.flatnonzero(factor != 1).tolist()
        of_model = self._one if len(widened) == 1 else self._several
        Q, E, g, taken, shares = of_model(widened, weight - 1)
        D, h = np.eye(self.k), np.zeros(self.k)
        for number in widened:
            q = self.q[self.sums.of_class[number]]
            D += (weight[number] - 1) * (q.T @ q)
            h += (weight[number] - 1) * (q.T @ self.whole[self.sums.of_class[number]])
        L, failed = dpotrf(D - taken, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the weighted rows say nothing of some unknown")
        own, _ = dpotrs(L, h - g[1], lower=1)
        inverse = triangular_inverse(L.T)
        self.root, self.c = triangular_inverse(L.T @ self.r), -self.first @ (self.along + own)
        beside = self.q[: self.n] - Q[: self.n] @ E
        self.told = beside @ inverse
        shares += self._summed(np.vecdot(self.told, self.told))
        return self.whole[: self.n] - Q[: self.n] @ g[0] - beside @ own, self.sums.rows - weight * shares

    def _one(self, widened: Sequence[int], more: FloatArray) -> "_OfModel":
        number = widened[0]
        turned, rows = one_widened(self.evidence, self.fit, number), self.sums.of_class[number]
        G = 1 + more[number] * turned.values
        B = more[number] * (turned.Q[rows].T @ self.q[rows])
        E, h = B / G[:, None], more[number] * turned.pull - B @ self.along
        return turned.Q, E, (h / G, E.T @ h), E.T @ B, turned.diagonal @ (1 / G)

    def _several(self, widened: Sequence[int], more: FloatArray) -> "_OfModel":
        p, Q = self.fit.Q.shape[1], self.fit.Q
        G, B = np.eye(p), np.zeros((p, self.k))
        for number in widened:
            rows = self.sums.of_class[number]
            G += more[number] * self.sums.square[number].reshape(p, p)
            B += more[number] * (Q[rows].T @ self.q[rows])
        L, failed = dpotrf(G, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the weighted rows say nothing of some unknown")
        E, _ = dpotrs(L, B, lower=1)
        h = more[widened] @ self.sums.pull[widened] - B @ self.along
        g, _ = dpotrs(L, h, lower=1)
        inverse, _ = dpotri(L, lower=1)
        inverse = inverse + inverse.T  # LAPACK makes the lower half; the upper one is nought
        inverse.flat[:: p + 1] *= 0.5
        shares, flat = np.zeros(len(self.sums.rows)), inverse.ravel()
        seen = np.flatnonzero([len(rows) for rows in self.sums.of_class]).tolist()
        shares[seen] = [self.sums.square[number] @ flat for number in seen]
        return Q, E, (g, E.T @ h), E.T @ B, shares

    def least_dof(self) -> float:
        """Return the least degrees of freedom behind the classes that tell most of the term."""
        by_class = self._summed(np.vecdot(self.told, self.told)) / self.factor**2
        telling = by_class[1:] > MIN_INFORMATION_SHARE * by_class.sum()
        return float(min(KNOWN_VARIANCE_DOF * 10, self.dof[1:][telling].min(initial=np.inf)))


_OfModel = tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray], FloatArray, FloatArray]
"""Columns Q (m, p), E (p, k), ``G0^-1 h`` (p,) and ``E' h`` (k,), ``E' G0 E`` (k, k), each class's shares (c,)."""
