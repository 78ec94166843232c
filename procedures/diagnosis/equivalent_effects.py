"""Which other effects could take a finding's place.

An effect is an alias where, fitted beside the finding and held to its own plausible range, it brings some
combination of the finding's coefficients that stood above three sigma below it. The combinations looked at are
each coefficient; where none of them stands by itself, the best combination and those whose sigma the other widens
most (eigenvectors of the one covariance in the other's metric). Some direction at three sigma is always lost to
anything that overlaps at all: beside coefficients that stand by themselves it is no other explanation.

A true finding keeps its value beside another effect, only its sigma grows; a false one's value goes to nought
beside the true cause.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh

from procedures.arrays import BoolArray, FloatArray
from procedures.diagnosis.linear_model import LinearFit, Term, coefficients_beside
from procedures.diagnosis.residual_rows import Evidence

STANDS_SIGMAS = 3.0  # sigmas
MAX_LEFT_SHARE = (
    0.5  # of a combination's sigmas, left at most: less is noise about the threshold, not another explanation
)
MIN_WIDENING = 3.0  # times, by the other, that a mixed combination's sigma must be to be worth looking at


def are_aliases(evidence: Evidence, finding: LinearFit, others: Sequence[Term]) -> list[bool]:
    """Say of each of ``others`` whether it could be what the last term of a fit, a ``finding``, is taken for."""
    if not others:
        return []
    c, C = finding.coefficients()
    beside = coefficients_beside(evidence, finding, others)
    if not np.any(np.abs(c) > STANDS_SIGMAS * np.sqrt(np.diag(C))):
        return [_is_alias(c, C, *each) for each in beside]
    W = _combinations(c, C, C)  # the same whatever stands beside it
    shifted, wider = (np.array(each) for each in zip(*beside, strict=True))
    return [bool(each.any()) for each in _lost(W, c, C, shifted, wider)]


def _is_alias(c: FloatArray, C: FloatArray, shifted: FloatArray, wider: FloatArray) -> bool:
    return bool(_lost(_combinations(c, C, wider), c, C, shifted, wider).any())


def _lost(W: FloatArray, c: FloatArray, C: FloatArray, shifted: FloatArray, wider: FloatArray) -> BoolArray:
    """Say which combinations W (m, k) stood and no longer do, of one or several others (j, m)."""
    stood = np.abs(W @ c) / np.sqrt(np.vecdot(W @ C, W))
    stands = np.abs(shifted @ W.T) / np.sqrt(np.vecdot(W @ wider, W))
    lost: BoolArray = (stood > STANDS_SIGMAS) & (stands < np.minimum(STANDS_SIGMAS, MAX_LEFT_SHARE * stood))
    return lost


def _combinations(c: FloatArray, C: FloatArray, wider: FloatArray) -> FloatArray:
    """Return combinations (m, k) of k coefficients worth looking at."""
    size = np.sqrt(np.diag(C))
    if np.any(np.abs(c) > STANDS_SIGMAS * size):
        return np.eye(len(c)) / size
    scaled, wide = C / np.outer(size, size), wider / np.outer(size, size)
    ratio, vectors = eigh(wide, scaled)
    best = np.linalg.solve(scaled, c / size)
    return np.vstack((best, vectors.T[ratio > MIN_WIDENING**2])) / size
