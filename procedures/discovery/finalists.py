"""The terms that come into question, their parameters fitted, and how well each foretells what is left out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery.library import LibraryTerm, Rows
from procedures.discovery.search import Scores, beside
from procedures.effects.effect import Columns
from procedures.statistics.least_squares import left_singular

MIN_SHARE = 0.6  # of the best gain, that a term off its best parameter must still have to be looked at
MOST = 100  # finalists
LEAST_SIGMAS = 10.0  # that a column may do to all rows together; more where it is found to do more
COST = 2.0  # ln density that a term pays for every factor and parameter: the simplest first
TOLERANCE = 2e-3  # of a parameter's logarithm


@dataclass(frozen=True, slots=True, eq=False)
class Finalist:
    """A term at its best parameter: columns H (n, k), what it does in sigmas (rows,), and how likely it is.

    ``density`` is by how much the data are likelier with it than with the model alone [ln marginal likelihood],
    less what its complexity costs. What is left out would be foretold better by a form of more coefficients, too,
    where that bends less at the ends: it is a test that a term must pass, no measure by which to choose.
    """

    term: LibraryTerm
    columns: Term
    does: FloatArray
    gain: float
    density: float

    def likeness(self, other: FloatArray) -> float:
        """Return the correlation, without unit, of what it does with what ``other`` (rows,) does in sigmas."""
        size = float(np.linalg.norm(self.does) * np.linalg.norm(other))
        return float(self.does @ other) / size if size else 0.0


def finalists(
    rows: Rows, fit: LinearFit, others: Sequence[Term], terms: Sequence[LibraryTerm], found: Scores,
    left_out: Sequence[IntArray],
) -> list[Finalist]:  # fmt: skip
    """Return the terms nearly as good as the best, at their best parameter, the one that foretells best first.

    ``left_out`` are the row numbers (r,) of each group to leave out.
    """
    most = float(found.gain.max())
    chosen = dict[tuple[str, tuple[str, ...]], LibraryTerm]()
    for number in np.argsort(-(found.gain - 2 * np.array([term.weight for term in terms]))).tolist():
        if len(chosen) == MOST or found.gain[number] < MIN_SHARE * most:
            break
        chosen.setdefault(terms[number].key, terms[number])
    each = [_finalist(rows, fit, _fitted(rows, fit, term)) for term in chosen.values()]
    return sorted(each, key=lambda one: -one.density)


def held_out(evidence: Evidence, others: Sequence[Term], left_out: Sequence[IntArray]) -> Callable[[Term], float]:
    """Return by how much ln density of what is left out gains with a term's columns beside others.

    ``left_out`` are the row numbers (r,), dimensionless, of each group.
    """
    as_is = np.ones(len(evidence.residual))
    before = predict_left_out(evidence, fit_linear(evidence, others, factor=as_is), left_out)[0]

    def gained(term: Term) -> float:
        after = fit_linear(evidence, [*others, term], factor=as_is)
        return predict_left_out(evidence, after, left_out)[0] - before

    return gained


def sized(evidence: Evidence, fit: LinearFit, H: FloatArray) -> Term:
    """Return columns H (n, k) [g, deg/s] with coefficients that may do as much as they are found to do."""
    W = np.zeros((len(fit.Q), H.shape[1]))
    W[: len(H)] = H / evidence.sigma[:, None]
    left = W - fit.Q @ (fit.Q.T @ W)
    c = np.linalg.lstsq(left, fit.whole, rcond=1e-6)[0]
    size = np.maximum(np.linalg.norm(left, axis=0), 1e-300)
    return Term(H, np.maximum(LEAST_SIGMAS / size, np.abs(c)))


def likelier(evidence: Evidence, fit: LinearFit, term: Term) -> float:
    """Return by how much a term makes the data likelier, its coefficients draws of its range [ln likelihood]."""
    W = np.zeros((len(fit.Q), term.H.shape[1]))
    W[: len(term.H)] = term.H * term.plausible / evidence.sigma[:, None]
    U, size = left_singular(W - fit.Q @ (fit.Q.T @ W))
    z = U.T @ fit.whole
    return float(0.5 * np.sum(z**2 * size**2 / (1 + size**2) - np.log1p(size**2)))


def _finalist(rows: Rows, fit: LinearFit, term: LibraryTerm) -> Finalist:
    W = rows.of([term])
    n = len(W)
    U = beside(fit, W)[:, 0]
    along = U.T @ fit.whole
    H = W.reshape(n, -1) * rows.evidence.sigma[:, None]
    columns = sized(rows.evidence, fit, H[:, np.abs(U).sum(axis=0) > 0])
    cost = COST * (term.weight - 1)
    density = likelier(rows.evidence, fit, columns) - cost
    return Finalist(term, columns, U @ along, float(along @ along), density)


def _fitted(rows: Rows, fit: LinearFit, term: LibraryTerm) -> LibraryTerm:
    """Return a term with its parameter where it explains most, between its neighbours on the grid."""
    if not term.shape:
        return term
    ((name, shape),) = term.shape.items()

    def less(log: float) -> float:
        W = rows.of([at(term, name, float(np.exp(log)))])
        U = beside(fit, W)[:, 0]
        return -float(np.sum((U.T @ fit.whole) ** 2))

    found = minimize_scalar(
        less, bounds=(np.log(shape.low), np.log(shape.high)), method="bounded", options={"xatol": TOLERANCE}
    )
    best = float(np.exp(found.x)) if found.fun < less(float(np.log(shape.value))) else shape.value
    return at(term, name, best)


def at(term: LibraryTerm, name: str, value: float) -> LibraryTerm:
    """Return a term with its parameter at another value."""
    shape = {name: replace(term.shape[name], value=value)}
    products = tuple(
        tuple(replace(factor, shape=shape) if factor.shape else factor for factor in product)
        for product in term.products
    )
    return LibraryTerm(term.triad, products, shape)


def candidate(evidence: Evidence, one: Finalist) -> Candidate:
    """Return a finalist as the tests of a diagnosis take it."""
    effect = one.term.as_effect("found", 1.0, "").effect()
    columns = Columns(tuple(str(i) for i in range(one.columns.H.shape[1])))
    return Candidate(effect, columns, one.columns, np.zeros(len(evidence.x), dtype=bool))
