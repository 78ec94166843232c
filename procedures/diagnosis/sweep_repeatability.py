"""What the sweeps of a rate table do not repeat is no structure: coefficients with each block left out.

Points of a sweep share more than noise: the table's drive, the enclosure's gradients. Errors so shared
make a fit over all points look surer than it is. The scatter of the coefficients with one block left out in turn
(delete-one jackknife, Efron and Stein 1981) holds whatever the points of a block share.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.fit_without_rows import without_rows
from procedures.diagnosis.linear_model import LinearFit, Term
from procedures.diagnosis.residual_rows import Evidence
from procedures.statistics.significance import log_f_sf

MIN_BLOCKS = 3
MAX_STD_IN_PLAUSIBLE = 0.5  # of its plausible size that 1 sigma of a coefficient must come down to


def std_of_repeats(evidence: Evidence, fit: LinearFit, left_out: Sequence[IntArray]) -> FloatArray:
    """Return 1 sigma (k,) of a fit's last term by what the blocks of rate tables repeat; nought without blocks.

    ``left_out`` are the row numbers (r,) of each group, the blocks among them.
    """
    blocks = _blocks(evidence, left_out)
    if len(blocks) < MIN_BLOCKS:
        return np.zeros(fit.sizes[-1])
    found = np.stack([without_rows(fit, rows).coefficients()[0] for rows in blocks])
    n = len(blocks)
    std: FloatArray = np.sqrt((n - 1) / n * np.sum((found - found.mean(axis=0)) ** 2, axis=0))
    return std


def log_p_of_repeats(
    evidence: Evidence, candidate: Candidate, others: Sequence[Term], left_out: Sequence[IntArray]
) -> float:
    """Return ln p of an effect's best coefficient by what the blocks repeat; -inf where there are none.

    ``left_out`` are the row numbers (r,), dimensionless, of each group, the blocks among them. The test is
    Student's t of one degree of freedom less than there are blocks, counted for every coefficient.
    """
    fit = candidate.fit(evidence, others)
    dof = len(_blocks(evidence, left_out)) - 1
    if dof + 1 < MIN_BLOCKS:
        return -np.inf
    std = std_of_repeats(evidence, fit, left_out)
    value, covariance = fit.coefficients()
    told = np.sqrt(np.diag(covariance)) < MAX_STD_IN_PLAUSIBLE * candidate.term.plausible
    t = (value[told] / std[told]) ** 2
    return min(log_f_sf(float(t.max()), 1, dof) + float(np.log(len(t))), 0.0) if len(t) else 0.0


def _blocks(evidence: Evidence, left_out: Sequence[IntArray]) -> list[IntArray]:
    rate = evidence.rows("rate")
    return [rows for rows in left_out if rate[rows].all()]
