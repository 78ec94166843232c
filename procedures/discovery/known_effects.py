"""Whether the catalogue has it: a known effect is never given another name.

What the diagnosis left in doubt, and every way in which an effect of the catalogue may have acted, is put in the
place of what was found. Where one foretells what is left out as well, nothing is proposed.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import IntArray
from procedures.diagnosis.candidates import Candidate, Candidates
from procedures.diagnosis.linear_model import LinearFit, Term
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.scatter import fitted_scatter, likeliest_gain
from procedures.discovery.finalists import Finalist, held_out, sized
from procedures.discovery.search import gain_of

DECISIVE = 3.0  # ln density by which a term must foretell better than what is known
MOST_COLUMNS = 20  # of an effect that is no scatter


def is_known(
    evidence: Evidence, fit: LinearFit, others: Sequence[Term], best: Finalist,
    pool: Candidates, doubtful: Sequence[Candidate], left_out: Sequence[IntArray],
    tried: int,
) -> bool:  # fmt: skip
    """Say whether an effect of the catalogue, or what is in doubt, explains as much as the best term.

    ``left_out`` are the row numbers (r,), dimensionless, of each group to leave out; ``tried`` terms were.
    """
    density = held_out(evidence, others, left_out)
    own = density(best.columns)
    if _scatter_is_as_good(evidence, fit, others, best, pool, tried):
        return True
    together = [each for each in doubtful if not each.effect.is_scatter]
    if together and density(_joined([each.term for each in together])) > own - DECISIVE:
        return True
    least = own - DECISIVE
    for name in pool:
        ways = [way for way in pool[name] if not way.is_of_model and not way.effect.is_scatter]
        for way in ways:
            H = way.term.H[:, np.any(way.term.H != 0, axis=0)]
            if not 0 < H.shape[1] <= MOST_COLUMNS or gain_of(evidence, fit, H) < 2 * least:
                continue  # held out, nothing gains more than half of its chi-square
            if density(sized(evidence, fit, H)) - np.log(len(ways)) > least:
                return True
    return False


def _joined(terms: Sequence[Term]) -> Term:
    return Term(np.hstack([each.H for each in terms]), np.concatenate([each.plausible for each in terms]))


def _scatter_is_as_good(
    evidence: Evidence, fit: LinearFit, others: Sequence[Term], best: Finalist,
    pool: Candidates, tried: int,
) -> bool:  # fmt: skip
    """Compare by marginal likelihood, the terms tried counted: a scatter of bench or hands foretells nothing."""
    unit = best.columns.H / np.maximum(np.linalg.norm(best.columns.H / evidence.sigma[:, None], axis=0), 1e-300)
    least = likeliest_gain(evidence, fit, unit) - np.log(tried) - DECISIVE
    found = (fitted_scatter(evidence, way, others) for way in pool.scatters())
    return any(one is not None and one.is_believed and one.gain > least for one in found)
