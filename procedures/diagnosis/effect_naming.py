"""Which name a finding goes by, how sure it is, and what else it could be."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import compress

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Solution
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.effect_selection import (
    MAX_LOG_P,
    MIN_DENSITY_GAIN,
    AdoptedEffect,
    density_gain,
    has_its_sign,
    is_plausible,
    stands_without_any,
)
from procedures.diagnosis.equivalent_effects import are_aliases
from procedures.diagnosis.explained_share import explained_share
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import Significance, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.other_memories import remembers_otherwise
from procedures.diagnosis.result import Because, Confidence, Finding, Reason
from procedures.diagnosis.scatter import MIN_MARGIN, fitted_scatter, marginal_gain, tested
from procedures.diagnosis.sign_flip_test import MAX_P, sign_flip_p
from procedures.diagnosis.sweep_repeatability import std_of_repeats
from procedures.diagnosis.thermal_alternatives import is_refined, other_explanations, plainer_or_refined
from procedures.diagnosis.walk_rivals import DRIFTS
from procedures.effects.effect import Effect
from procedures.errors import DoesNotFit
from procedures.frames import AXES, FACES

PARALLELISM, QUADRATIC = "fixture.parallelism", "accelerometer.quadratic"
PURE_FIXTURE_SIGMAS = 3.0  # by which two sums of faces' tilts along one axis must differ
OTHER_K = 1.0  # by which temperatures of recordings are others
LIKELIER_NATS = 5.0  # by how much likelier than the instrument's a cause at the bench is held to be [ln odds]
RANK = {"bench": 0, "procedure": 1, "instrument": 2}


def name_findings(state: LoopState, tried: int) -> tuple[LoopState, tuple[Finding, ...]]:
    """Name every finding, or the group it cannot be told from."""
    renamed = tuple(_renamed(state, each) for each in state.adopted)
    if any(new.candidate is not old.candidate for new, old in zip(renamed, state.adopted, strict=True)):
        with suppress(DoesNotFit):  # by the other name it does not fit: it keeps its own
            state = state.solved_with(_once(renamed))
    return state, tuple(_finding(state, each, tried) for each in state.adopted)


def _once(adopted: Sequence[AdoptedEffect]) -> list[AdoptedEffect]:
    found = dict[tuple[str, str, str], AdoptedEffect]()
    for each in adopted:
        columns = each.candidate.columns
        found.setdefault((each.candidate.effect.name, str(columns.where), columns.shape), each)
    return list(found.values())


def _others(state: LoopState, finding: Candidate) -> list[Candidate]:
    """Return the effects that could take a finding's place, in all their ways; looked for once where it stands."""
    if finding not in state.others:
        state.others[finding] = _looked_for(state, finding)
    return state.others[finding]


def _looked_for(state: LoopState, finding: Candidate) -> list[Candidate]:
    evidence = state.now.evidence
    fit = finding.fit(evidence, state.beside(finding))
    inside = {id(each.candidate) for each in state.adopted}
    is_of_bench = finding.effect.kind == "bench"  # else what is tied, held at its prior, is beside it anyway
    ways = (
        way
        for each in state.pool.values()
        for way in each
        if way.effect is not finding.effect and not is_refined(finding, way)
    )
    free = [way for way in ways if not (id(way) in inside or way.is_of_model or (way.tied and not is_of_bench))]
    if finding.effect.is_scatter:
        return _like_scatter(state, finding, free)
    scatters = [way for way in free if way.effect.is_scatter]
    others = [way for way in free if not way.effect.is_scatter]
    alike = list(compress(others, are_aliases(evidence, fit, [way.term for way in others])))
    alike += [way for way in _at_the_bench_instead(state, finding, others) if way not in alike]
    alike += [] if finding.is_of_model else _scatters_like(state, finding, scatters)
    if finding.effect.may_hang_on_a_step or finding.effect.kind != "instrument":
        return alike
    # A jump may be at any of a hundred places, and at one of them looks like much that is likelier
    alike = [way for way in alike if not way.effect.may_hang_on_a_step]
    return alike + _jumps_like(state, finding, others)


def _jumps_like(state: LoopState, finding: Candidate, ways: Sequence[Candidate]) -> list[Candidate]:
    """Return the likeliest jump of a triad's biases that foretells as well as what goes by time alone, or none."""
    triad, _, name = finding.effect.name.partition(".")
    if f".{name}" not in DRIFTS:
        return []
    jumps = [(_counted_gain(state, way, finding), way) for way in ways if way.effect.name == f"{triad}.jump"]
    gain, likeliest = max(jumps, key=lambda each: each[0], default=(-np.inf, finding))
    return [likeliest] if gain > _counted_gain(state, finding, finding) - LIKELIER_NATS else []


def _at_the_bench_instead(state: LoopState, finding: Candidate, ways: Sequence[Candidate]) -> list[Candidate]:
    """Return causes at the bench that are as likely as an instrument's effect, taken for what is likelier there.

    Each is seen by itself, over all that was tried. One coefficient of the bench explains less than nine of a
    sensor's, some of it noise: a wrong latitude is a magnetic sensitivity of every size in every direction.
    """
    if finding.effect.kind != "instrument" or finding.is_of_model:
        return []
    evidence, beside, tried = state.now.evidence, state.beside(finding), float(np.log(len(state.pool)))
    at_bench = [w for w in ways if w.effect.kind == "bench" and not w.effect.may_hang_on_a_step]
    seen = [w for w in at_bench if tested(evidence, w, beside).log_p + tried < MAX_LOG_P]
    least = _explains(state, finding, beside) - LIKELIER_NATS if seen else 0.0
    return [way for way in seen if _explains(state, way, beside) > least]


def _others_of_plausible_size(state: LoopState, finding: Candidate) -> list[Candidate]:
    """Return those of the others that could take a finding's place in the model as well as in its explanation."""
    evidence, beside = state.now.evidence, state.beside(finding)
    others = _others(state, finding)
    tests = [(way, tested(evidence, way, beside)) for way in others]
    return [way for way, test in tests if is_plausible(way, test) and has_its_sign(way, test)]


def _like_scatter(state: LoopState, finding: Candidate, ways: Sequence[Candidate]) -> list[Candidate]:
    """Return the effects that explain as much as a scatter does, the places of a jump counted."""
    evidence, beside = state.now.evidence, state.beside(finding)
    least = marginal_gain(evidence, finding, beside) - MIN_MARGIN
    return [way for way in ways if _explains(state, way, beside) > least]


def _scatters_like(state: LoopState, finding: Candidate, ways: Sequence[Candidate]) -> list[Candidate]:
    """Return the scatters, of the size found, that explain as much as an effect does."""
    evidence, beside = state.now.evidence, state.beside(finding)
    least = _explains(state, finding, beside) - MIN_MARGIN
    found = [scatter for way in ways if (scatter := fitted_scatter(evidence, way, beside)) is not None]
    return [each.candidate for each in found if each.is_believed and each.gain > least]


def _explains(state: LoopState, way: Candidate, beside: Sequence[Term]) -> float:
    """Return what a way explains [ln marginal likelihood], the ways of its effect counted."""
    return marginal_gain(state.now.evidence, way, beside) - float(np.log(max(len(state.pool[way.effect.name]), 1)))


def _counted_gain(state: LoopState, way: Candidate, instead_of: Candidate) -> float:
    """Return what the left-out rows gain by a way in the place of one, its places or time constants counted."""
    evidence = state.now.evidence
    gain = density_gain(evidence, way, state.beside(instead_of), left_out_groups(evidence))
    counts = way.effect.may_hang_on_a_step or way.columns.nonlinear
    places = len(state.pool[way.effect.name]) if counts else 1
    return gain - float(np.log(places))


def _renamed(state: LoopState, adopted: AdoptedEffect) -> AdoptedEffect:
    """Return a finding under its group's name: the bench's, the procedure's, or what foretells best."""
    others = _others_of_plausible_size(state, adopted.candidate)
    group = [adopted.candidate, *others, *plainer_or_refined(state, adopted.candidate)]
    kind, likelier = adopted.candidate.effect.kind, min(RANK[each.effect.kind] for each in group)
    if len(group) == 1 or (kind != "instrument" and RANK[kind] == likelier):
        return adopted
    group = [each for each in group if each.is_tried]
    if any(each.effect.added for each in group):
        gains = [_exact_gain(state, adopted, each) for each in group]
    else:
        gains = [_counted_gain(state, each, adopted.candidate) for each in group]
    # What takes but a part of a finding's place foretells less by far: it gives no name to the whole
    # (a scatter foretells nothing; that it is as likely was asked before)
    least = max(gains) - LIKELIER_NATS
    as_likely = [each.effect for each in group if each.effect.is_scatter]
    as_likely += [each.effect for each in _at_the_bench_instead(state, adopted.candidate, others)]
    near = [each for each in zip(group, gains, strict=True) if each[1] > least or each[0].effect in as_likely]
    rank = min(RANK[each.effect.kind] for each, _ in near)
    ranked = [each for each in near if RANK[each[0].effect.kind] == rank]
    best, order = max(gain for _, gain in ranked), list(state.pool)
    close = (each for each in ranked if each[1] > best - MIN_DENSITY_GAIN)
    named = min(close, key=lambda each: order.index(each[0].effect.name))
    return replace(adopted, candidate=named[0], gain=named[1]) if named[0] is not adopted.candidate else adopted


def _exact_gain(state: LoopState, adopted: AdoptedEffect, instead: Candidate) -> float:
    """Return how well the left-out rows are foretold with another effect in the place of one, bent as it is."""
    others = [each for each in state.adopted if each is not adopted]
    try:
        there = state.solved_with([*others, replace(adopted, candidate=instead)])
    except DoesNotFit:
        return -np.inf
    fit = fit_linear(there.now.evidence, there.beside(), factor=state.now.linear.factor)
    return predict_left_out(there.now.evidence, fit, left_out_groups(there.now.evidence))[0]


def settle_nonlinear(state: LoopState) -> LoopState:
    """Settle at once which of a group it is, where one is not linear: they leave different residuals."""
    if not state.adopted:
        return state
    last = state.adopted[-1]
    group = [last.candidate, *_others(state, last.candidate)]
    if not any(each.effect.added for each in group):
        return state
    renamed = _renamed(state, last)
    with suppress(DoesNotFit):
        state = state if renamed is last else state.solved_with((*state.adopted[:-1], renamed))
    return state


def _finding(state: LoopState, adopted: AdoptedEffect, tried: int) -> Finding:
    candidate, evidence = adopted.candidate, state.now.evidence
    beside = state.beside(candidate)
    fit, left_out = candidate.fit(evidence, beside), left_out_groups(evidence)
    test = tested(evidence, candidate, beside)
    ways = max(len(state.pool.get(candidate.effect.name, ())), 1)
    log_p = min(test.log_p + np.log(tried * ways), 0.0)
    gain = density_gain(evidence, candidate, beside, left_out)
    alike = (each.effect.name for each in _others(state, candidate))
    others = (*other_explanations(state, candidate), *_by_temperature(state, candidate))
    aliases = tuple(dict.fromkeys((*alike, *others)))
    flipped = None if candidate.effect.is_scatter else sign_flip_p(evidence, candidate, beside)
    is_sure = log_p < MAX_LOG_P and gain > MIN_DENSITY_GAIN and (flipped is None or flipped <= MAX_P)
    if candidate.effect.may_hang_on_a_step:
        is_sure = is_sure and stands_without_any(evidence, candidate, beside, left_out)
    if candidate.effect.is_scatter:
        is_sure = False  # a function of the input that nobody knows has no pattern that we know either
    # A scatter foretells nothing: its p, all that was tried counted, is all that speaks for it
    is_thin = candidate.effect.is_scatter and log_p >= MAX_LOG_P
    reasons = [Reason(Because.NOT_SIGNIFICANT, value=log_p / float(np.log(10)))] if is_thin else []
    reasons += [Reason(Because.MEMORY)] if remembers_otherwise(state, candidate) else []
    confidence: Confidence = "ambiguous" if aliases or reasons else "established" if is_sure else "likely"
    effect, columns = candidate.effect, candidate.columns
    told = np.asarray(candidate.term.H.any(axis=0))
    told[len(told) - len(candidate.columns.nonlinear) :] = True  # at the end of its range it has no slope
    repeats = 0.0 if candidate.effect.is_scatter else std_of_repeats(evidence, fit, left_out)
    value, std = test.value, np.maximum(test.std, repeats)
    value, std = (value, std) if effect.shown is None else effect.shown(value, std)
    if columns.nonlinear:
        first, nonlinear = len(value) - len(columns.nonlinear), np.array(list(columns.nonlinear.values()))
        value, std = np.append(value[:first], nonlinear), np.append(std[:first], nonlinear * std[first:])
    names = tuple(np.array(columns.coefficients)[told].tolist())
    if effect.is_scatter:
        names, told, (value, std) = ("value",), np.ones(1, dtype=bool), _size_of(candidate, test)
    return Finding(
        effect.name, effect.kind, names, value[told], std[told], columns.unit or effect.unit,
        _where(state, candidate), confidence, aliases, _what_would_tell(state, effect), log_p, gain,
        columns.shape, flipped, explained_share(evidence, candidate, beside, left_out), tuple(reasons),
        state.pool.same_as(candidate),
    )  # fmt: skip


def _by_temperature(state: LoopState, candidate: Candidate) -> tuple[str, ...]:
    """Return the coefficient that biases of recordings at other temperatures may have, of whatever order."""
    triad, _, name = candidate.effect.name.partition(".")
    temperature = state.now.evidence.excitation.temperature
    known = temperature[np.isfinite(temperature)]
    is_warmer = len(known) > 0 and float(np.ptp(known)) > OTHER_K
    return (f"{triad}.bias_temperature",) if name == "turn_on_bias" and is_warmer else ()


def _size_of(scatter: Candidate, test: Significance) -> tuple[FloatArray, FloatArray]:
    """Return a scatter's whole 1 sigma, what was stated in it, (1,) and 1 sigma of that; the median step's."""
    stated = scatter.effect.stated_share * scatter.effect.plausible_of(scatter.columns)
    more, std = np.median(test.value), np.median(test.std)
    whole = float(np.hypot(np.median(stated), more))
    return np.array([whole]), np.array([std * more / whole if whole else std])


def _what_would_tell(state: LoopState, effect: Effect) -> str:
    """Return the measurement that would tell an effect from its aliases; not one that is there already."""
    is_certified = all(len(each.fixture.faces) == len(FACES) for each in state.now.fits.campaigns)
    return (is_certified and effect.separate_by_certified) or effect.separate_by


def _where(state: LoopState, finding: Candidate) -> Mapping[str, object]:
    """Return what a finding is about; of a seating that its pair's other could be instead, both positions."""
    where = dict(finding.columns.where)
    if also := [way.columns.where["position"] for way in other_seatings(state, finding)]:
        several = list(dict.fromkeys([where["position"], *also]))
        where["position"] = several if len(several) > 1 else several[0]
    return where


def other_seatings(state: LoopState, finding: Candidate) -> list[Candidate]:
    """Return the other positions that could have been seated so instead of a finding's."""
    if "position" not in finding.columns.where:
        return []
    evidence = state.now.evidence
    fit = finding.fit(evidence, state.beside(finding))
    ways = state.pool.get(finding.effect.name, ())
    others = [way for way in ways if way is not finding]
    return list(compress(others, are_aliases(evidence, fit, [way.term for way in others])))


def with_fixture_channels(findings: tuple[Finding, ...], base: Solution) -> tuple[Finding, ...]:
    """Return findings, parallelism that may be the sensor's with the channels in which part of it is not."""
    found = _pure_fixture(base)
    return tuple(
        replace(each, where={**each.where, "channel": list(found)})
        if each.effect == PARALLELISM and QUADRATIC in each.aliases and found
        else each
        for each in findings
    )


def _pure_fixture(solution: Solution) -> tuple[str, ...]:
    """Return the accelerometer channels along which the cube's own faces differ for certain, in cube axes.

    Along an axis q lie two sums of opposite faces' tilts, those of the pairs of the two other axes. K2, a scale
    asymmetry and the bias move both alike; their difference is the fixture's, or a seating's, alone.
    """
    if solution.parallelism is None:
        return ()
    rows = [i for i, name in enumerate(solution.names) if name.startswith(PARALLELISM)]
    value, less = dict(zip(rows, solution.parallelism.value.ravel(), strict=True)), np.array([1, -1])
    found = list[str]()
    for q in AXES:
        one, other = along = [i for i in rows if solution.names[i].endswith(f".{q}")]
        std = np.sqrt(less @ solution.covariance[np.ix_(along, along)] @ less)
        if abs(value[one] - value[other]) > PURE_FIXTURE_SIGMAS * std:
            found.append(f"a{q}")
    return tuple(found)
