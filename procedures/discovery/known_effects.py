"""Whether the catalogue has it: a known effect is never given another name.

What the diagnosis left in doubt, and every way in which an effect of the catalogue may have acted, is put in the
place of what was found. Where one of a plausible size foretells what is left out as well, nothing is proposed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from procedures.arrays import IntArray
from procedures.diagnosis.candidates import Candidate, Candidates, term_of
from procedures.diagnosis.effect_selection import has_its_sign, is_plausible
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, significance
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.scatter import fitted_scatter, likeliest_gain
from procedures.discovery.finalists import MIN_SHARE, Finalist, held_out, sized
from procedures.discovery.search import gain_of

DECISIVE = 3.0  # ln density by which a term must foretell better than what is known
MOST_COLUMNS = 20  # of an effect that is no scatter
NEIGHBOURS = 2.0  # times: how far the next time constant, play or knee of a catalogue's search lies at most
TOLERANCE = 0.01  # of their logarithm


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
    for name in pool:
        ways = [way for way in pool[name] if not way.is_of_model and not way.effect.is_scatter]
        is_bent = any(way.columns.nonlinear for way in ways)  # its one parameter is fitted, as the term's own is
        least = own - DECISIVE + (0.0 if is_bent else float(np.log(max(len(ways), 1))))
        for way in _ways(evidence, fit, ways):
            if gain_of(evidence, fit, way.term.H) < MIN_SHARE * best.gain:
                continue  # it does not come into question, as no term does
            if density(sized(evidence, fit, way.term.H)) > least and _may_be(evidence, way, others):
                return True
    return False


def _may_be(evidence: Evidence, way: Candidate, others: Sequence[Term]) -> bool:
    """Say whether an effect would be of a plausible size, and a loss lose: what a diagnosis asks of it."""
    free = sized(evidence, fit_linear(evidence, others, factor=np.ones(len(evidence.residual))), way.term.H)
    test = significance(evidence, fit_linear(evidence, [*others, free]))
    return is_plausible(way, test) and has_its_sign(way, test)


def _ways(evidence: Evidence, fit: LinearFit, ways: Sequence[Candidate]) -> Iterator[Candidate]:
    """Yield an effect's ways by their columns that act here, and the best one with its one parameter fitted."""
    every = [_acting(way, way.term) for way in ways]
    every = [way for way in every if 0 < way.term.H.shape[1] <= MOST_COLUMNS]
    yield from every
    if every and len(every[0].columns.nonlinear) == 1:
        yield _fitted(evidence, fit, max(every, key=lambda way: gain_of(evidence, fit, way.term.H)))


def _fitted(evidence: Evidence, fit: LinearFit, way: Candidate) -> Candidate:
    """Return a way at the time constant, play or knee that explains most."""
    ((name, value),) = way.columns.nonlinear.items()
    bent = way.effect.at
    assert bent is not None

    def at(log: float) -> Candidate:
        columns = replace(way.columns, nonlinear={name: value * float(np.exp(log))})
        return _acting(way, term_of(evidence, way.effect, bent(evidence.excitation, columns)))

    by = float(np.log(NEIGHBOURS))
    best = minimize_scalar(
        lambda log: -gain_of(evidence, fit, at(log).term.H), bounds=(-by, by), method="bounded",
        options={"xatol": TOLERANCE},
    )  # fmt: skip
    return at(float(best.x))


def _acting(way: Candidate, term: Term) -> Candidate:
    """Return a way by those of a term's columns that are not nought."""
    acts = np.any(term.H != 0, axis=0)
    return replace(way, term=Term(term.H[:, acts], term.plausible[acts]))


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
