"""Biases that walk at random, where a recording at rest is not explained and nobody recorded a temperature.

The random walk of a bias is a term of every inertial sensor's noise (K of IEEE Std 952 and 1293). Its size and
that of a wider white noise, w times the counting noise's, are found by the marginal likelihood of the triad's rows
(REML: Patterson and Thompson 1971),

    V = w^2 + k^2 W W',   L = -1/2 (ln|V| + ln|Q' V^-1 Q| + y' P y),   P = V^-1 - V^-1 Q (Q' V^-1 Q)^-1 Q' V^-1

with y the whitened rows, Q what the model fits, W the walk's columns. The walk is tested against the wider white
noise alone: 2 (L - L0) is half chi-square of 1 degree of freedom. What walks is foretold between rests by its
neighbours, not by a line. It has no cause: a temperature that nobody recorded walks as well, and a short line of
time is as likely. So it is ambiguous always, and stays out of the calibration, whose sigmas stay as wide.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from procedures.arrays import BoolArray, FloatArray
from procedures.diagnosis.effect_selection import MIN_DENSITY_GAIN
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.random_walk import walk_columns
from procedures.diagnosis.refit import Refit
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.result import Finding
from procedures.frames import TRIADS
from procedures.statistics.significance import log_chi2_sf
from procedures.units import DEG_H_PER_DEG_S

NAME = "bias_walk"
MAX_LOG_P = np.log(0.01)
MAX_NAMED = 4  # recordings
MAX_ROWS = 300  # of a triad: of 600 the likelihoods take 24 s of a processor
LOG_STEP, TOLERANCE = 0.05, 1e-3
FIRST_TIMES = (0.1, 1.0, 10.0)  # of the walk that does 1 sigma of a row, from which its size is sought
FIRST_WHITE = (-2.0, 2.0)  # ln of the noise beyond counting noise, over it
LEAST_LOG, MOST_LOG = -12.0, 12.0
UNITS = {"accelerometer": ("g/sqrt(h)", 1.0), "gyroscope": ("deg/h/sqrt(h)", DEG_H_PER_DEG_S)}
MAY_BE = ("bias_drift", "bias_temperature")
SEPARATE_BY = "a thermometer beside the sensor, and ten times as long: a line goes on, a walk does not"


@dataclass(frozen=True, slots=True, eq=False)
class BiasWalk:
    """A triad's walk: its ``term``, the rows' ``white`` noise over counting noise, what it gains of likelihood.

    ``size`` is K [g, deg/s per sqrt(h)] with ``std`` of its logarithm.
    """

    term: Term
    rows: BoolArray
    size: float
    std: float
    white: float
    gain: float

    @property
    def log_p(self) -> float:
        """Ln p of half chi-square, counted as one of two triads."""
        half = float(log_chi2_sf(2 * max(self.gain, 0.0), 1)) - float(np.log(2))
        return min(half + float(np.log(len(TRIADS))), 0.0)


def with_bias_walks(state: LoopState, findings: Sequence[Finding]) -> tuple[Refit, tuple[Finding, ...]]:
    """Return the last fit with the walks that were found in it, and all findings; those given where none is."""
    evidence = state.now.evidence
    if evidence.rows("mean", "turn", "rate").any() or np.isfinite(evidence.excitation.temperature).any():
        return state.now, tuple(findings)
    named = {each.effect.partition(".")[0] for each in findings}
    now, terms, found = state.now, state.beside(), list(findings)
    for triad in TRIADS:
        walk = None if triad in named else bias_walk(evidence, triad, state.beside())
        if walk is not None and walk.log_p < MAX_LOG_P and (told := _told(state, now.linear, walk, terms, triad)):
            now, terms = replace(now, linear=told[0]), [*terms, walk.term]
            found.append(told[1])
    return now, tuple(found)


def bias_walk(evidence: Evidence, triad: str, others: Sequence[Term]) -> BiasWalk | None:
    """Return the likeliest walk of a triad's biases beside the model and other terms; None where none is seen."""
    rows = evidence.rows("norm", "soak", triad=triad)
    H = walk_columns(evidence, triad)
    if not 0 < rows.sum() <= MAX_ROWS or not H[rows].any():
        return None
    before = fit_linear(evidence, others, factor=np.ones(len(evidence.residual)))
    W = H[rows] / evidence.sigma[rows, None]
    C = W @ W.T
    unit = 1 / np.sqrt(float(np.diag(C).max()))

    def less(at: FloatArray) -> float:
        walk, white = np.exp(2 * np.clip(at, LEAST_LOG, MOST_LOG))
        return -1.0 * _log_likelihood(before, rows, np.diag(np.full(len(C), 1 + white)) + walk * unit**2 * C)

    def less_without(at: FloatArray) -> float:
        return less(np.array([LEAST_LOG, at[0]]))

    null = min(_least(less_without, np.array([white]))[1] for white in FIRST_WHITE)
    ways = [_least(less, np.array([np.log(times), 0.0])) for times in FIRST_TIMES]
    best, least = min(ways, key=lambda way: way[1])
    size = float(np.exp(best[0])) * unit
    k = H.shape[1]
    bend = _bend(less, best)
    return BiasWalk(
        Term(H, np.full(k, size)), rows, size, 1 / np.sqrt(bend) if bend > 0 else np.inf,
        float(np.sqrt(1 + np.exp(2 * best[1]))), null - least,
    )  # fmt: skip


def _least(less: Callable[[FloatArray], float], first: FloatArray) -> tuple[FloatArray, float]:
    """Return where a function of some logarithms (k,) is least, and its value there."""
    found = minimize(less, first, method="Nelder-Mead", options={"xatol": TOLERANCE, "fatol": TOLERANCE})
    return np.asarray(found.x, dtype=np.float64), float(found.fun)


def _log_likelihood(before: LinearFit, rows: BoolArray, V: FloatArray) -> float:
    """Return the restricted ln likelihood; the whitened rows marked (n,) have covariance V (r, r), others 1."""
    marked = np.zeros(len(before.whole), dtype=bool)
    marked[: len(rows)] = rows
    Q, y = before.Q[marked], before.whole[marked]
    factor = cho_factor(V, lower=True)
    VQ, Vy = cho_solve(factor, Q), cho_solve(factor, y)
    other, rest = before.Q[~marked], before.whole[~marked]
    M, b = Q.T @ VQ + other.T @ other, Q.T @ Vy + other.T @ rest
    squares = float(y @ Vy + rest @ rest - b @ np.linalg.solve(M, b))
    return -float(np.sum(np.log(np.diag(factor[0])))) - 0.5 * (float(np.linalg.slogdet(M)[1]) + squares)


def _bend(less: Callable[[FloatArray], float], at: FloatArray) -> float:
    """Return the second derivative of minus ln likelihood by the logarithm of the walk's size."""
    step = np.array([LOG_STEP, 0.0])
    return (less(at + step) + less(at - step) - 2 * less(at)) / LOG_STEP**2


def _told(
    state: LoopState, now: LinearFit, walk: BiasWalk, others: Sequence[Term], triad: str
) -> tuple[LinearFit, Finding] | None:
    """Return the fit with a walk beside other terms and its finding; None where it foretells no better."""
    evidence = state.now.evidence
    left_out = left_out_groups(evidence)
    factor = np.where(walk.rows, walk.white, now.factor)
    before, after = (fit_linear(evidence, terms, factor=factor) for terms in (others, [*others, walk.term]))
    was, old = predict_left_out(evidence, before, left_out)
    becomes, new = predict_left_out(evidence, after, left_out)
    foretold = np.isfinite(old) & walk.rows
    if becomes - was < MIN_DENSITY_GAIN or not np.all(np.isfinite(new[foretold])):
        return None
    share = 1 - float(np.sum(new[foretold] ** 2 * factor[foretold] ** 2 - 1)) / max(
        float(np.sum(old[foretold] ** 2 * factor[foretold] ** 2 - 1)), 1.0
    )
    unit, per = UNITS[triad]
    size = np.array([walk.size * per])
    files = sorted({step.name.partition(" block ")[0] for step in evidence.excitation.steps})
    return after, Finding(
        f"{triad}.{NAME}", "instrument", ("value",), size, size * walk.std, unit,
        {"file": files if len(files) <= MAX_NAMED else [files[0], f"{len(files) - 1} more"]},
        "ambiguous", tuple(f"{triad}.{name}" for name in MAY_BE), SEPARATE_BY, walk.log_p, becomes - was,
        share=float(np.clip(share, 0.0, 1.0)),
    )  # fmt: skip
