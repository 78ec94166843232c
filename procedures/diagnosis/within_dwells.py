"""What stays unexplained within the dwells, for the uncertainty of what their means give.

Scatter of means, turns and norms shows in the fit itself, which widens its sigmas by it. What rates do within a
dwell does not: slope and curvature are no rows of the fit. White noise gives a slope as much as it gives the mean
(a ramp's rms over a dwell, in sigmas of the mean, is its slope in sigmas of the slope), so by as many squares of
its sigma as the shapes have too many, the mean is off as well.
"""

from collections.abc import Mapping

import numpy as np

from procedures.diagnosis.linear_model import LinearFit
from procedures.diagnosis.residual_rows import TRIADS, Evidence

SHAPES = ("slope", "curvature")


def within_dwells(evidence: Evidence, fit: LinearFit) -> Mapping[str, float]:
    """Return by triad the variance that wanders within its dwells, in squares of the mean's counting noise.

    ``fit`` is the last, with unwidened sigmas.
    """
    found = dict[str, float]()
    for triad in TRIADS:
        rows = evidence.rows(*SHAPES, triad=triad)
        free = float(np.sum((1 - fit.leverage)[rows]))
        if free > 0:
            found[triad] = max(float(np.sum(fit.white[rows] ** 2)) / free - 1, 0.0)
    return found
