"""Whether anything is left: the global test, of every class of rows by its sum of squares and its worst row.

A single chi-square over some hundred rows would not see one dwell that is six sigma off; the classes are
few, so each is tested and the least p counts as one of so many.
"""

from collections.abc import Sequence

import numpy as np

from procedures.diagnosis.linear_model import LinearFit, Term, classes, fit_linear
from procedures.diagnosis.residual_rows import KINDS, Evidence
from procedures.statistics.tail_probabilities import log_f_sf

ABSORBED = 0.02  # a row of which the fit leaves less is the fit's, not the data's
LEAST = 2.0  # degrees of freedom of a class worth testing


def log_global_p(evidence: Evidence, terms: Sequence[Term]) -> float:
    """Return ln p of the residual under counting noise, with the terms in the model."""
    fit = fit_linear(evidence, terms, factor=np.ones(len(evidence.residual)))
    return log_p_of(evidence, fit)


def log_p_of(evidence: Evidence, fit: LinearFit) -> float:
    """Return ln p of what a fit with unwidened sigmas leaves."""
    shared, free = classes(evidence), 1 - fit.leverage
    told = (evidence.kind != KINDS.index("prior")) | ~evidence.is_range
    found = list[float]()
    for number in np.unique(shared[told]):
        rows = told & (shared == number)
        dof = float(free[rows].sum())
        clear = rows & (free > ABSORBED)
        if dof < LEAST or not clear.any():
            continue
        k = max(round(dof), 1)
        found.append(log_f_sf(float(np.sum(fit.white[rows] ** 2)) / k, k, evidence.noise_dof))
        worst = float(np.max(fit.white[clear] ** 2 / free[clear]))
        found.append(log_f_sf(worst, 1, evidence.noise_dof) + np.log(clear.sum()))
    return min(min(found) + np.log(len(found)), 0.0) if found else 0.0


def excess(evidence: Evidence, fit: LinearFit) -> float:
    """Return by how much the data's sum of squares exceeds what noise leaves; at least nought."""
    rows = evidence.is_data
    return max(float(np.sum(fit.white[rows] ** 2) - np.sum((1 - fit.leverage)[rows])), 0.0)
