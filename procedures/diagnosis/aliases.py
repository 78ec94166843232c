"""Which other effects could take a finding's place.

An effect is an alias where, fitted beside the finding and held to its own plausible range, it brings some
combination of the finding's coefficients that stood above three sigma below it. The combinations looked at are
each coefficient, the best one, and those whose sigma the other widens most (eigenvectors of the one covariance in
the other's metric). A true finding keeps its value beside another effect, only its sigma grows; a false one's
value goes to nought beside the true cause.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.evidence import Evidence
from procedures.diagnosis.model import Term

STANDS = 3.0  # sigmas
LOST = 0.5  # of a combination's sigmas, left at most: less is noise about the threshold, not another explanation
WIDENED = 3.0  # times, by the other, that a mixed combination's sigma must be to be worth looking at


def takes_its_place(evidence: Evidence, finding: Candidate, other: Term, beside: Sequence[Term]) -> bool:
    """Say whether ``other`` could be what ``finding`` is taken for; ``beside`` are what else is in the model."""
    alone = finding.fit(evidence, beside)
    c, C = alone.coefficients()
    shifted, wider = finding.fit(evidence, [*beside, other], alone.factor).coefficients()
    for w in _combinations(c, C, wider):
        stood = abs(w @ c) / np.sqrt(w @ C @ w)
        stands = abs(w @ shifted) / np.sqrt(w @ wider @ w)
        if stood > STANDS > stands and stands < LOST * stood:
            return True
    return False


def _combinations(c: FloatArray, C: FloatArray, wider: FloatArray) -> FloatArray:
    """Return combinations (m, k) of k coefficients worth looking at."""
    size = np.sqrt(np.diag(C))
    scaled, wide = C / np.outer(size, size), wider / np.outer(size, size)
    ratio, vectors = eigh(wide, scaled)
    best = np.linalg.solve(scaled, c / size)
    found: FloatArray = np.vstack((np.eye(len(c)), best, vectors.T[ratio > WIDENED**2])) / size
    return found
