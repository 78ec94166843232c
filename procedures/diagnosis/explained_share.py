"""Which share of what noise does not explain an effect does, on rows left out.

    share = 1 - X(with it) / X(without it),   X = sum over groups of e' (I - L)^-1 e - r

e (r,) is a group's whitened residual, L its block of the hat matrix: the error made where the group is held
out, over what its uncertainty is, less what noise makes of it. A term that is hardly determined would gain by
its own uncertainty, so the share is at most that of the errors themselves: of ``d' d``, d = (I - L)^-1 e, less
what noise makes of it without the term, in the directions that both models predict. If d grows, the term
explains nothing. All other effects are in the model both times. The groups are what was measured, or what was
stated as well, whichever the effect explains more of: a turn that is left out brings its own closure, so that a
bend of the scale factor shows in the stated closures alone.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.linear_model import LinearFit, Term
from procedures.diagnosis.residual_rows import Evidence
from procedures.frames import TRIADS

MIN_FREE_SHARE = 0.01  # of a direction's variance that the rest leaves open: below, it is not foretold at all


def held_out_excess(
    evidence: Evidence, fit: LinearFit, left_out: Sequence[IntArray], *, with_stated: bool = False
) -> float:
    """Return by how much the squares of the errors where measured rows are held out exceed noise; at least nought.

    ``left_out`` are the row numbers (r,), dimensionless, of each group; ``fit`` has sigmas that are not widened.
    ``with_stated``: what was stated counts like what was measured.
    """
    excess = 0.0
    for rows in left_out:
        if evidence.is_data[rows[0]] or with_stated:
            Q = fit.Q[rows]
            excess += _beyond_noise(np.eye(len(rows)) - Q @ Q.T, fit.white[rows])
    return max(excess, 0.0)


def _beyond_noise(M: FloatArray, e: FloatArray) -> float:
    """Return by how much the squares of held-out errors, over their variance, exceed noise; M (r, r), e (r,)."""
    values, vectors = np.linalg.eigh(M)
    seen = values > MIN_FREE_SHARE
    return float(np.sum((vectors.T @ e)[seen] ** 2 / values[seen] - 1))


def share_of_own_triad(
    evidence: Evidence, candidate: Candidate, others: Sequence[Term], left_out: Sequence[IntArray]
) -> float:
    """Return the same of the excess that an instrument's effect can explain at all: that of its own triad.

    ``left_out`` are the row numbers (r,), dimensionless, of each group.
    """
    triad = candidate.effect.name.partition(".")[0]
    if triad in TRIADS:
        own = [rows[evidence.triad[rows] == TRIADS.index(triad)] for rows in left_out]
        left_out = [rows for rows in own if len(rows)]
    return explained_share(evidence, candidate, others, left_out)


def explained_share(
    evidence: Evidence, candidate: Candidate, others: Sequence[Term], left_out: Sequence[IntArray]
) -> float:
    """Return the share (0 to 1) of the excess, where rows are left out, that an effect explains beside others.

    ``left_out`` are the row numbers (r,), dimensionless, of each group. What the model holds from the start, slab
    and faces, explains nothing of what it leaves: 0.
    """
    if candidate.is_of_model:
        return 0.0
    as_is = np.ones(len(evidence.residual))
    before, after = candidate.without(evidence, others, as_is), candidate.fit(evidence, others, as_is)
    return share_of_fits(evidence, before, after, left_out) or 0.0


def share_of_fits(
    evidence: Evidence, before: LinearFit, after: LinearFit, left_out: Sequence[IntArray]
) -> float | None:
    """Return the share (0 to 1) of the excess of a fit that is none of another's; None where it has no excess.

    ``left_out`` are the row numbers (r,), dimensionless, of each group.
    """
    shares = list[float]()
    for with_stated in (False, True):
        without, with_it = (
            held_out_excess(evidence, fit, left_out, with_stated=with_stated) for fit in (before, after)
        )
        if without > 0:
            share = min(1 - with_it / without, _share_of_errors(evidence, before, after, left_out, with_stated))
            shares.append(max(share, 0.0))
    return max(shares, default=None)


def _share_of_errors(
    evidence: Evidence, before: LinearFit, after: LinearFit, left_out: Sequence[IntArray], with_stated: bool
) -> float:
    """Return the share of the held-out errors' squares beyond noise by which they fall; 1 where all is noise."""
    fell = excess = 0.0
    for rows in left_out:
        if evidence.is_data[rows[0]] or with_stated:
            parts = [(np.eye(len(rows)) - fit.Q[rows] @ fit.Q[rows].T, fit.white[rows]) for fit in (before, after)]
            values, vectors = np.linalg.eigh(parts[1][0])  # the larger model predicts no more than the smaller one
            seen, unseen = vectors[:, values > MIN_FREE_SHARE], vectors[:, values <= MIN_FREE_SHARE]
            squares = [float(np.sum(np.linalg.solve(seen.T @ M @ seen, seen.T @ e) ** 2)) for M, e in parts]
            noise = float(np.trace(np.linalg.inv(seen.T @ parts[0][0] @ seen)))
            only = _beyond_noise(unseen.T @ parts[0][0] @ unseen, unseen.T @ parts[0][1])
            fell += squares[0] - squares[1] + only  # nothing predicts a single step: what it shows, is of the term
            excess += squares[0] - noise + only
    return fell / excess if excess > 0 else 1.0
