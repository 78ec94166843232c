"""Selection that does not cry wolf: one effect at a time, over all that were tried, and only if it foretells.

In every round each candidate is tested beside what was adopted before; the smallest p counts as one of as many as
were tried (Holm 1979). The winner must improve the rows that were left out in turn, its size must be plausible,
no single step may carry it alone, the sweeps of a rate table must repeat it, and no other campaign of the unit may
speak against it. After each adoption those before are tested again, and dropped if the newcomer explains what they
did.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import IntArray
from procedures.diagnosis.candidates import Candidate, raising_does_not_fit
from procedures.diagnosis.fit_without_rows import without_rows
from procedures.diagnosis.held_out_errors import campaign_groups
from procedures.diagnosis.linear_model import (
    MIN_EXPECTED_SIGMAS,
    Significance,
    Term,
    borne_out,
    predict_left_out,
    significance,
)
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.scatter import MAX_SIZE, fitted_scatter, marginal_gain
from procedures.diagnosis.sweep_repeatability import log_p_of_repeats
from procedures.diagnosis.term_trial import tried_term
from procedures.effects.effect import Effect
from procedures.errors import DoesNotFit
from procedures.statistics.significance import holm

# Of the adjusted p. The words would allow 0.05 for likely; that names what is not there in more than 1 %.
MAX_LOG_P = np.log(0.01)
MAX_TIMES_PLAUSIBLE = 5.0  # times its plausible size a coefficient is not believed
MAX_LOG_P_WITHOUT_A_STEP = np.log(0.05)  # p that must stay whichever step is left out
MIN_DENSITY_GAIN = 0.5  # of log predictive density, below which the left-out rows say neither yes nor no
MIN_GAIN_IN_A_CAMPAIGN = -1.0  # of it, below which a whole campaign left out speaks against an effect
# Of it, what a coefficient of nought costs where one of two equal campaigns is left out
COST_OF_A_COEFFICIENT = 0.5 * np.log(2)
SCATTERS_SHARE = 0.5  # of all false alarms: headings, closures, seats
NEARLY = 0.95  # of the likelihood that a scatter gains: what explains so much leaves products of its own
MAX_EFFECTS = 8  # effects


@dataclass(frozen=True, slots=True, eq=False)
class TestedEffect:
    """A candidate and its test beside what was adopted; ``log_p`` counts the ways its effect was tried in."""

    candidate: Candidate
    test: Significance
    log_p: float
    log_p_adjusted: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class AdoptedEffect:
    """An effect that entered the model: how it was found, and what the left-out rows gained by it (ln density)."""

    candidate: Candidate
    tried: TestedEffect
    gain: float

    @property
    def term(self) -> Term:
        """Its columns."""
        return self.candidate.term


def rank_effects(
    evidence: Evidence, pool: Mapping[str, Sequence[Candidate]], adopted: Sequence[AdoptedEffect] = ()
) -> list[TestedEffect]:
    """Test every effect beside what was adopted, the best of its ways each; the least p first."""
    terms = [each.term for each in adopted if not each.candidate.is_of_model]
    taken = {(each.candidate.effect.name, str(each.candidate.columns.where)) for each in adopted}
    found = list[TestedEffect]()
    for name, ways in pool.items():
        free = [way for way in ways if way.is_tried and (name, str(way.columns.where)) not in taken]
        tests = [found_so for way in free if (found_so := _tested(evidence, way, terms)) is not None]
        if tests:
            way, test = min(tests, key=lambda each: each[1].log_p)
            found.append(TestedEffect(way, test, min(test.log_p + np.log(len(tests)), 0.0)))
    left = _without_scatters_of_one(evidence, found, terms)
    weighted = {id(each): each.log_p - log_weight(each.candidate.effect, pool) for each in left}
    found = sorted(left, key=lambda each: weighted[id(each)])
    adjusted = holm({number: weighted[id(each)] for number, each in enumerate(found)}, are_logs=True)
    return [replace(each, log_p_adjusted=adjusted[number]) for number, each in enumerate(found)]


def log_weight(effect: Effect, pool: Mapping[str, Sequence[Candidate]]) -> float:
    """Return ln of the weight by which an effect's p is divided; of mean 1 (Genovese, Roeder, Wasserman 2006).

    Scatters, which are likelier than most others, have `SCATTERS_SHARE` of all false alarms among them.
    """
    tried, scatters = len(pool), sum(ways[0].effect.is_scatter for ways in pool.values())
    if not 0 < scatters < tried:
        return 0.0
    share = SCATTERS_SHARE / scatters if effect.is_scatter else (1 - SCATTERS_SHARE) / (tried - scatters)
    return float(np.log(tried * share))


def _without_scatters_of_one(
    evidence: Evidence, found: Sequence[TestedEffect], terms: Sequence[Term]
) -> list[TestedEffect]:
    """Leave scatters out that one thing of bench or procedure explains nearly as well: one seating off is none."""
    single = [
        each.candidate for each in found
        if each.candidate.effect.kind != "instrument" and not each.candidate.effect.is_scatter
        and not each.candidate.is_of_model and each.log_p < MAX_LOG_P
    ]  # fmt: skip
    gains = [2 * marginal_gain(evidence, way, terms) for way in single]
    most = max(gains, default=-np.inf)
    return [each for each in found if not each.candidate.effect.is_scatter or most < NEARLY * each.test.statistic]


def _tested(evidence: Evidence, way: Candidate, terms: Sequence[Term]) -> tuple[Candidate, Significance] | None:
    """Return one way, a scatter of the size found, and its test; None where the model leaves too little to see."""
    try:
        with raising_does_not_fit():
            if way.effect.is_scatter:
                scatter = fitted_scatter(evidence, way, terms)
                return None if scatter is None else (scatter.candidate, scatter.test)
            if way.is_of_model:
                return way, significance(evidence, way.fit(evidence, terms))
            test = tried_term(evidence, tuple(terms), way.term)
            return None if test is None else (way, test)
    except DoesNotFit:
        return None


def next_effect(
    evidence: Evidence,
    tried: Sequence[TestedEffect],
    adopted: Sequence[AdoptedEffect],
    left_out: Sequence[IntArray],
) -> AdoptedEffect | None:
    """Return the best of those tried that is significant, plausible, foretells, and hangs on no single step.

    An effect that is seen only as long as a better one, which is too large, is left out takes the place of that
    one, as a jump or a drift of the temperature's doing. It is not the cause.

    ``left_out`` are the row numbers (r,), dimensionless, of each group to leave out.
    """
    too_large = list[TestedEffect]()
    terms = [each.term for each in adopted if not each.candidate.is_of_model]
    for each, gain in _borne_out(evidence, tried, adopted, left_out):
        if not is_plausible(each.candidate, each.test):
            too_large.append(each)
        elif not any(_takes_the_place(evidence, each, large, terms, len(tried)) for large in too_large):
            return AdoptedEffect(each.candidate, each, gain)
    return None


def _takes_the_place(
    evidence: Evidence, effect: TestedEffect, large: TestedEffect, terms: Sequence[Term], tried: int
) -> bool:
    """Say whether an instrument's effect is not seen beside one that is too large, which is seen beside it."""
    if effect.candidate.effect.kind != "instrument" or large.candidate.effect is effect.candidate.effect:
        return False
    free = Term(large.candidate.term.H, large.candidate.term.plausible * times_plausible(large))
    with suppress(DoesNotFit), raising_does_not_fit():
        its_own = significance(evidence, effect.candidate.fit(evidence, [*terms, free])).log_p
        ways = effect.log_p - effect.test.log_p
        beside = replace(large.candidate, term=free).fit(evidence, [*terms, effect.candidate.term])
        is_seen = significance(evidence, beside).log_p + np.log(tried) < MAX_LOG_P
        return is_seen and bool(its_own + ways + np.log(tried) > MAX_LOG_P)
    return False


def too_large_effects(
    evidence: Evidence,
    tried: Sequence[TestedEffect],
    adopted: Sequence[AdoptedEffect],
    left_out: Sequence[IntArray],
) -> list[TestedEffect]:
    """Return those tried that nothing but their size speaks against, the best first; as `next_effect`.

    ``left_out`` are the row numbers (r,), dimensionless, of each group to leave out.
    """
    borne_out = (each for each, _ in _borne_out(evidence, tried, adopted, left_out))
    return [each for each in borne_out if not is_plausible(each.candidate, each.test)]


def _borne_out(
    evidence: Evidence,
    tried: Sequence[TestedEffect],
    adopted: Sequence[AdoptedEffect],
    left_out: Sequence[IntArray],
) -> Iterator[tuple[TestedEffect, float]]:
    """Yield those that are significant, foretell, and hang on no single step, whatever their size; their gain."""
    terms = [each.term for each in adopted if not each.candidate.is_of_model]
    for each in tried:
        if each.log_p_adjusted >= MAX_LOG_P:
            return
        with suppress(DoesNotFit), raising_does_not_fit():
            gain = density_gain(evidence, each.candidate, terms, left_out)
            if (
                gain > 0
                and has_its_sign(each.candidate, each.test)
                and log_p_of_repeats(evidence, each.candidate, terms, left_out) + np.log(len(tried)) < MAX_LOG_P
                and (
                    each.candidate.effect.may_hang_on_a_step
                    or stands_without_any(evidence, each.candidate, terms, left_out)
                )
                and holds_in_every_campaign(evidence, each.candidate, terms)
            ):
                yield each, gain


def has_its_sign(candidate: Candidate, test: Significance) -> bool:
    """Say whether no coefficient of a loss is below nought by more than its sigma tells."""
    return not candidate.effect.is_loss or bool(np.all(test.value > -2 * test.std))


def is_plausible(candidate: Candidate, test: Significance) -> bool:
    """Say whether every coefficient lies in its plausible range, as far as its sigma tells."""
    if candidate.effect.is_scatter:
        return bool(
            np.all(candidate.term.plausible <= MAX_SIZE * candidate.effect.plausible_of(candidate.columns))
        )
    low = np.abs(test.value) - 2 * test.std
    return bool(np.all(low < MAX_TIMES_PLAUSIBLE * candidate.term.plausible))


def times_plausible(tried: TestedEffect) -> float:
    """Return how many times its plausible size the largest coefficient is."""
    candidate = tried.candidate
    if candidate.effect.is_scatter:
        return float(np.max(candidate.term.plausible / candidate.effect.plausible_of(candidate.columns)))
    return float(np.max(np.abs(tried.test.value) / candidate.term.plausible))


def density_gain(
    evidence: Evidence, candidate: Candidate, others: Sequence[Term], left_out: Sequence[IntArray]
) -> float:
    """Return by how much the left-out rows are better foretold with a candidate than without [ln density].

    ``left_out`` are the row numbers (r,) of each group.
    """
    after = candidate.fit(evidence, others)
    before = candidate.without(evidence, others, after.factor)
    return predict_left_out(evidence, after, left_out)[0] - predict_left_out(evidence, before, left_out)[0]


def stands_without_any(
    evidence: Evidence, candidate: Candidate, others: Sequence[Term], left_out: Sequence[IntArray]
) -> bool:
    """Say whether an instrument's effect is seen whichever position is left out: one bad dwell is none.

    ``left_out`` are the row numbers (r,), dimensionless, of each position or step.

    Where a step tells so much of it that the others could hardly (the one fast turn among slow ones), these must
    at least show of it what they would with 95 % probability.
    """
    if candidate.effect.kind != "instrument":
        return True
    fit = candidate.fit(evidence, others)
    told = significance(evidence, fit)
    for rows in left_out:
        if not evidence.is_data[rows[0]]:
            continue
        if len(fit.Q) - len(rows) < fit.Q.shape[1]:  # what remains determines no fit, and confirms nothing
            return False
        again = significance(evidence, without_rows(fit, rows))
        if again.log_p > MAX_LOG_P_WITHOUT_A_STEP and borne_out(told, again) < -MIN_EXPECTED_SIGMAS:
            return False
    return True


def holds_in_every_campaign(evidence: Evidence, candidate: Candidate, others: Sequence[Term]) -> bool:
    """Say whether no campaign speaks against an instrument's effect that the others see without it.

    One that is seen only where the campaigns stand beside each other, as a coefficient of temperature that was
    steady in each, cannot be foretold from the others, and is not held to that.
    """
    if candidate.effect.kind != "instrument":
        return True
    fit = candidate.fit(evidence, others)
    against = MIN_GAIN_IN_A_CAMPAIGN - COST_OF_A_COEFFICIENT * len(candidate.term.plausible)
    for rows in campaign_groups(evidence):
        is_seen = significance(evidence, without_rows(fit, rows)).log_p < MAX_LOG_P_WITHOUT_A_STEP
        if is_seen and density_gain(evidence, candidate, others, [rows]) < against:
            return False
    return True
