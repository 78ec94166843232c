"""A check of a finding that assumes no distribution: the signs of whole steps' residuals are turned at random.

Without the effect a step's residual would as soon have had the other sign. The rows of a step keep or change their
sign together, and each thing stated by itself, so that whatever noise a step's rows share stays shared. The
statistic is the score of the effect's columns as far as the model leaves them (Hemerik, Goeman and Finos 2020,
effective scores),

    T = H' G r,    V = H' G (1 - P) G H,    T' V^-1 T

with r = (1 - P) y the whitened residual without the effect, H = (1 - P) H too, G the signs. V is what T scatters
by under G: a fit with few rows to spare makes them dependent, and without V turned signs would look too quiet.

An effect that acts in a few steps only, or of which the model leaves little, looks much the same whatever the
signs. So the same is done to noise of the known size with the effect as found in it: where that is not told from
its flips either, they say nothing. Where they could tell and do not (p > 0.05), the finding rests on the noise
being what was assumed, or on a few steps: it stays, as the other tests bear it out, but as likely at best.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.linear_model import Term
from procedures.diagnosis.residual_rows import Evidence
from procedures.statistics.least_squares import left_singular

FLIPS = 999
SEED = 20180611
DRAWS = 40  # of noise with the effect in it
MAX_P = 0.05  # p up to which signs tell an effect
MIN_POWER = 0.9  # share of the draws in which they must
NULL_SHARE = 1e-9  # of what tells most of an effect: below it the model leaves nothing of a combination


def sign_flip_p(evidence: Evidence, candidate: Candidate, others: Sequence[Term]) -> float | None:
    """Return the share of sign flips with which an effect stands out as much as it does, at least 1 / 1000.

    ``others`` are the terms beside it. None where too few steps speak of it for signs to tell.
    """
    after = candidate.fit(evidence, others)
    null = candidate.without(evidence, others, after.factor)
    wide = np.zeros((len(null.whole), candidate.term.H.shape[1]))
    wide[: len(after.factor)] = candidate.term.H / (evidence.sigma * after.factor)[:, None]
    wide -= null.Q @ (null.Q.T @ wide)
    noise = np.random.default_rng(SEED).standard_normal((len(wide), DRAWS))
    drawn = (wide @ after.coefficients()[0])[:, None] + noise - null.Q @ (null.Q.T @ noise)
    p = _p(_spanning(wide), null.Q, np.column_stack((null.whole, drawn)), _groups(evidence, len(wide)))
    return float(p[0]) if np.mean(p[1:] <= MAX_P) >= MIN_POWER else None


def _spanning(H: FloatArray) -> FloatArray:
    """Return orthonormal columns that span H's, less those of which nothing is left."""
    U, size = left_singular(H)
    return U[:, size**2 > NULL_SHARE * size[0] ** 2]


def _groups(evidence: Evidence, rows: int) -> IntArray:
    """Return which rows change sign together (rows,): those of a step; every other alone."""
    alone = np.arange(rows) + len(evidence.excitation.steps)
    alone[: len(evidence.step)] = np.where(evidence.is_data, evidence.step, alone[: len(evidence.step)])
    _, found = np.unique(alone, return_inverse=True)
    return found


def _p(H: FloatArray, Q: FloatArray, r: FloatArray, together: IntArray) -> FloatArray:
    """Return for every residual in the columns of r (rows, d) the share (d,) of flips that stand out as much."""
    m, k = together.max() + 1, H.shape[1]
    scores, absorbed = np.zeros((m, k, r.shape[1])), np.zeros((m, Q.shape[1], k))
    for group in range(m):
        rows = together == group
        scores[group], absorbed[group] = H[rows].T @ r[rows], Q[rows].T @ H[rows]
    signs = np.random.default_rng(SEED).choice([-1.0, 1.0], (FLIPS + 1, m))
    signs[0] = 1.0
    T, lost = np.tensordot(signs, scores, axes=1), np.tensordot(signs, absorbed, axes=1)
    V = (1 + NULL_SHARE) * np.eye(k) - np.matmul(lost.transpose(0, 2, 1), lost)
    statistic = np.sum(T * np.linalg.solve(V, T), axis=1)
    found: FloatArray = np.mean(statistic >= statistic[0] * (1 - 1e-9), axis=0)
    return found
