"""Whether anything is left: the global test, of every class of rows by its sum of squares and its worst row.

A single chi-square over some hundred rows would not see one dwell that is six sigma off; the classes are
few, so each is tested and the least p counts as one of so many.
"""

import numpy as np

from procedures.diagnosis.linear_model import LinearFit, variance_classes
from procedures.diagnosis.residual_rows import KINDS, Evidence
from procedures.frames import TRIADS
from procedures.statistics.significance import log_f_sf
from procedures.uncertainty.sources import Unexplained

MIN_ROW_FREEDOM = 0.02  # a row of which the fit leaves less is the fit's, not the data's
SHAPES = ("slope", "curvature")
MIN_CLASS_DOF = 2.0  # degrees of freedom of a class worth testing


def global_log_p(evidence: Evidence, fit: LinearFit) -> float:
    """Return ln p of what a fit with unwidened sigmas leaves."""
    shared, free = variance_classes(evidence), 1 - fit.leverage
    told = (evidence.kind != KINDS.index("prior")) | ~evidence.is_range
    found = list[float]()
    for number in np.unique(shared[told]):
        rows = told & (shared == number)
        dof = float(free[rows].sum())
        clear = rows & (free > MIN_ROW_FREEDOM)
        if dof < MIN_CLASS_DOF or not clear.any():
            continue
        k = max(round(dof), 1)
        found.append(log_f_sf(float(np.sum(fit.white[rows] ** 2)) / k, k, evidence.noise_dof))
        worst = float(np.max(fit.white[clear] ** 2 / free[clear]))
        found.append(log_f_sf(worst, 1, evidence.noise_dof) + np.log(clear.sum()))
    return min(min(found) + np.log(len(found)), 0.0) if found else 0.0


def excess_squares(
    evidence: Evidence, fit: LinearFit, triad: str | None = None, *, with_stated: bool = False
) -> float:
    """Return by how much the data's sum of squares exceeds what noise leaves, of a triad or both; >= 0.

    ``with_stated``: what was stated counts as well, as headings and closures were.
    """
    rows = evidence.is_data | (evidence.is_stated & with_stated)
    rows = rows if triad is None else rows & (evidence.triad == TRIADS.index(triad))
    return max(float(np.sum(fit.white[rows] ** 2) - np.sum((1 - fit.leverage)[rows])), 0.0)


def within_dwells(evidence: Evidence, fit: LinearFit) -> dict[str, Unexplained]:
    """Return by triad the variance that wanders within its dwells, in squares of the mean's counting noise.

    ``fit`` is the last, with unwidened sigmas. Scatter of means, turns and norms widens its sigmas; slope and
    curvature within a dwell are no rows of a calibration's fit. White noise gives a slope as much as it gives the
    mean (a ramp's rms over a dwell, in sigmas of the mean, is its slope in sigmas of the slope), so by as many
    squares of its sigma as the shapes have too many, the mean is off as well.
    """
    found = dict[str, Unexplained]()
    for triad in TRIADS:
        rows = evidence.rows(*SHAPES, triad=triad)
        free = float(np.sum((1 - fit.leverage)[rows]))
        if free > 0:
            found[triad] = Unexplained(max(float(np.sum(fit.white[rows] ** 2)) / free - 1, 0.0))
    return found
