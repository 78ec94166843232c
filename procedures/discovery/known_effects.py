"""Whether the catalogue has it: a known effect is never given another name.

What the diagnosis left in doubt, and every way in which an effect of the catalogue may have acted, is put in the
place of what was found. Where one of a plausible size foretells what is left out as well, nothing is proposed.
"""

from collections.abc import Sequence
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
        counted = float(np.log(max(len(ways), 1)))
        # a parameter that is fitted is paid for by the term as well: only the places of the others count
        both = [(way, counted) for way in _acting_here(ways)] + [
            (way, 0.0) for way in fitted_way(evidence, fit, ways)
        ]
        for way, cost in both:
            if gain_of(evidence, fit, way.term.H) < MIN_SHARE * best.gain:
                continue  # it does not come into question, as no term does
            gained = density(sized(evidence, fit, way.term.H)) - cost
            if gained > own - DECISIVE and _may_be(evidence, way, others):
                return True
    return False


def _may_be(evidence: Evidence, way: Candidate, others: Sequence[Term]) -> bool:
    """Say whether an effect would be of a plausible size, and a loss lose: what a diagnosis asks of it."""
    free = sized(evidence, fit_linear(evidence, others, factor=np.ones(len(evidence.residual))), way.term.H)
    test = significance(evidence, fit_linear(evidence, [*others, free]))
    return is_plausible(way, test) and has_its_sign(way, test)


def _acting_here(ways: Sequence[Candidate]) -> list[Candidate]:
    """Return an effect's ways by their columns that act here, those with few enough of them."""
    every = [_acting(way, way.term) for way in ways]
    return [way for way in every if 0 < way.term.H.shape[1] <= MOST_COLUMNS]


def fitted_way(evidence: Evidence, fit: LinearFit, ways: Sequence[Candidate]) -> list[Candidate]:
    """Return of ways with one time constant, play or knee the best, at the value that explains most; or none.

    Raises nothing where a value does nothing at all, as a knee above the fastest rate.
    """
    bent = [way for way in _acting_here(ways) if len(way.columns.nonlinear) == 1 and way.effect.at is not None]
    if not bent:
        return []
    way = max(bent, key=lambda each: gain_of(evidence, fit, each.term.H))
    ((name, value),) = way.columns.nonlinear.items()
    low, high = way.effect.ranges.get(name, (0.0, np.inf))
    ends = max(low, value / NEIGHBOURS), min(high, value * NEIGHBOURS)

    def at(log: float) -> Candidate:
        assert way.effect.at is not None
        columns = way.effect.at(evidence.excitation, replace(way.columns, nonlinear={name: float(np.exp(log))}))
        return _acting(replace(way, columns=columns), term_of(evidence, way.effect, columns))

    def less(log: float) -> float:
        H = at(log).term.H
        return -gain_of(evidence, fit, H) if H.shape[1] else 0.0  # above the fastest rate a knee does nothing

    best = minimize_scalar(
        less,
        bounds=(float(np.log(ends[0])), float(np.log(ends[1]))),
        method="bounded",
        options={"xatol": TOLERANCE},
    )
    found = at(float(best.x))
    return [found] if found.term.H.shape[1] else []


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
