"""The closed loop: residual, effect, model, residual again.

    evidence -> candidates -> one effect at a time -> parameters solved again -> what is left

until nothing significant, plausible and foretelling is left; then every finding is held against what could take
its place, and the whole against noise.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.calibration import fit_reduced, reduce_steps
from procedures.campaign import Campaign
from procedures.diagnosis.aliases import takes_its_place
from procedures.diagnosis.candidates import Candidate, candidates
from procedures.diagnosis.combined import combined, with_files
from procedures.diagnosis.errors_made import errors_made
from procedures.diagnosis.faces import faces_as_positions
from procedures.diagnosis.groups import groups
from procedures.diagnosis.model import Term, fit_linear, held_out, significance
from procedures.diagnosis.preliminary import preliminary
from procedures.diagnosis.rate_tables import RateTables
from procedures.diagnosis.refit import Refit, terms_at
from procedures.diagnosis.repeats import std_of_repeats
from procedures.diagnosis.result import Confidence, Diagnosis, Finding, Test, Verdict
from procedures.diagnosis.selection import (
    ESTABLISHED,
    GAIN,
    LIKELY,
    MOST,
    Adopted,
    Tried,
    gain_of,
    next_effect,
    try_all,
)
from procedures.diagnosis.sign_flip import TOLD, sign_flip_p
from procedures.diagnosis.subject import Bench, Subject
from procedures.diagnosis.unexplained import excess, log_p_of
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.errors import NotObservable

UNEXPLAINED = np.log(0.01)
LEFT = np.log(
    1e-3
)  # ln p of what is left, below which an effect must have explained nearly all it was brought for
EXPLAINS = 0.95
RANK = {"bench": 0, "procedure": 1, "instrument": 2}

Pool = Mapping[str, Sequence[Candidate]]


@dataclass(frozen=True, eq=False)
class _State:
    """Where the loop stands."""

    subject: Subject
    adopted: tuple[Adopted, ...]
    now: Refit
    pool: Pool

    def beside(self, but: Candidate | None = None) -> list[Term]:
        """Return the terms added to the model, but for one."""
        return [each.term for each in self.adopted if not each.candidate.is_of_model and each.candidate is not but]


def diagnose(campaigns: Sequence[Campaign], effects: Sequence[Effect] = EFFECTS) -> Diagnosis:
    """Find what the residual of one unit's campaigns says the model lacks, and add it.

    Raises
    ------
    NotObservable
        If neither triad can be solved, and no rate table's sensor either.
    """
    tables = RateTables.of(campaigns)
    if tables is None:
        return _of_steps(campaigns, effects)
    of_tables = with_files(_closed(tables, effects))
    try:
        return combined(_of_steps(campaigns, effects), of_tables)
    except NotObservable:
        return of_tables


def _of_steps(campaigns: Sequence[Campaign], effects: Sequence[Effect]) -> Diagnosis:
    """Diagnose dwells, turns and rests, put right first where that is no matter of a linear model."""
    found_before = preliminary([faces_as_positions(campaign) for campaign in campaigns])
    effects = [effect for effect in effects if effect.name not in found_before.settled]
    steps = reduce_steps(found_before.campaigns)
    found = _closed(Bench(steps, fit_reduced(steps)), effects)
    findings = (*found_before.findings, *found.findings)
    return replace(
        found, verdict=_verdict(findings, found.log_p), findings=findings,
        tried=(*found_before.tests, *found.tried), next_measurement=_next(findings),
    )  # fmt: skip


def _closed(subject: Subject, effects: Sequence[Effect]) -> Diagnosis:
    """Add effects to a base model, one at a time, until nothing is left that any of them would explain."""
    state = first = _stand(subject, (), effects)
    tried = list[Tried]()
    for _ in range(MOST):
        found = try_all(state.now.evidence, state.pool, state.adopted)
        tried = tried or found
        new = next_effect(state.now.evidence, found, state.adopted, groups(state.now.evidence))
        if new is None:
            break
        both = (*state.adopted, new)
        state = replace(state, adopted=both) if new.candidate.is_of_model else _stand(subject, both, effects)
        state = _dropped(_best_bent(state, effects), effects)
    state = _honest(state, effects)
    state, findings = _named(state, len(first.pool), effects)
    left = _left(state)
    return Diagnosis(
        _verdict(findings, left), findings, tuple(_test(each) for each in tried),
        errors_made(first.now.evidence, state.now, groups(first.now.evidence)), first.now.fits,
        state.now.fits, state.now.evidence, subject.report(first.now), subject.report(state.now), left,
        _next(findings),
        tuple(each.candidate for each in state.adopted if not each.candidate.is_of_model), state.now.values,
    )  # fmt: skip


def _stand(subject: Subject, adopted: Sequence[Adopted], effects: Sequence[Effect]) -> _State:
    """Solve with what was adopted and look again at everything from there."""
    now = subject.refit([each.candidate for each in adopted])
    pool = candidates(now.evidence, now.fits, effects)
    found = [_found_again(each, pool) for each in adopted]
    return _State(subject, tuple(_bent(found, now)), now, pool)


def _bent(adopted: Sequence[Adopted], now: Refit) -> Iterator[Adopted]:
    """Yield effects that are not linear with their columns at the coefficients found."""
    values = iter(now.values)
    for each in adopted:
        candidate = each.candidate
        value = None if candidate.is_of_model else next(values)
        if value is not None and candidate.effect.added is not None:
            (term,), _ = terms_at(now.evidence, [candidate], [value])
            each = replace(each, candidate=replace(candidate, term=term))
        yield each


def _found_again(adopted: Adopted, pool: Pool) -> Adopted:
    """Return an adopted effect with its columns where the model now stands."""
    old = adopted.candidate
    for way in pool.get(old.effect.name, ()):
        if way.columns.where == old.columns.where and way.columns.shape == old.columns.shape:
            return replace(adopted, candidate=way)
    return adopted


def _dropped(state: _State, effects: Sequence[Effect]) -> _State:
    """Drop effects that those adopted after them explain."""
    for each in state.adopted[:-1]:
        test = significance(
            state.now.evidence, each.candidate.fit(state.now.evidence, state.beside(each.candidate))
        )
        if test.log_p + np.log(len(state.pool)) > LIKELY:
            kept = [other for other in state.adopted if other is not each]
            return _stand(state.subject, kept, effects)
    return state


def _left(state: _State) -> float:
    """Return ln p of what the model with all its effects leaves."""
    evidence = state.now.evidence
    return log_p_of(evidence, fit_linear(evidence, state.beside(), factor=np.ones(len(evidence.residual))))


def _honest(state: _State, effects: Sequence[Effect]) -> _State:
    """Drop effects that leave more than a little of what they were brought in to explain."""
    while _left(state) < LEFT:
        wanting = [
            (share, each)
            for each in state.adopted
            if not each.candidate.is_of_model and (share := _explained(state, each.candidate)) < EXPLAINS
        ]
        if not wanting:
            break
        worst = min(wanting, key=lambda each: each[0])[1]
        state = _stand(state.subject, [each for each in state.adopted if each is not worst], effects)
    return state


def _explained(state: _State, candidate: Candidate) -> float:
    """Return how much of what noise does not explain a candidate does."""
    evidence, ones = state.now.evidence, np.ones(len(state.now.evidence.residual))
    without = excess(evidence, fit_linear(evidence, state.beside(candidate), factor=ones))
    with_it = excess(evidence, fit_linear(evidence, state.beside(), factor=ones))
    return 1 - with_it / without if without > 0 else 0.0


def _named(state: _State, tried: int, effects: Sequence[Effect]) -> tuple[_State, tuple[Finding, ...]]:
    """Name every finding, or the group it cannot be told from."""
    renamed = tuple(_renamed(state, each, effects) for each in state.adopted)
    if any(new.candidate is not old.candidate for new, old in zip(renamed, state.adopted, strict=True)):
        state = _stand(state.subject, _once(renamed), effects)
    return state, tuple(_finding(state, each, tried) for each in state.adopted)


def _once(adopted: Sequence[Adopted]) -> list[Adopted]:
    found = dict[tuple[str, str, str], Adopted]()
    for each in adopted:
        columns = each.candidate.columns
        found.setdefault((each.candidate.effect.name, str(columns.where), columns.shape), each)
    return list(found.values())


def _others(state: _State, finding: Candidate) -> list[Candidate]:
    """Return the effects that could take a finding's place, the best of the ways of each."""
    evidence, beside = state.now.evidence, state.beside(finding)
    inside = {id(each.candidate) for each in state.adopted}
    found = list[Candidate]()
    for ways in state.pool.values():
        for way in ways:
            if way.effect is finding.effect or id(way) in inside or way.is_of_model or _holds(way, finding):
                continue
            if takes_its_place(evidence, finding, way.term, beside):
                found.append(way)
    return found


def _holds(other: Candidate, finding: Candidate) -> bool:
    """Say whether the model holds another effect at its prior already: then it is beside the finding anyway."""
    return other.tied and finding.effect.kind != "bench"


def _renamed(state: _State, adopted: Adopted, effects: Sequence[Effect]) -> Adopted:
    """Return a finding under its group's name: the bench's, the procedure's, or what foretells best."""
    group = [adopted.candidate, *_others(state, adopted.candidate)]
    evidence, beside, left_out = state.now.evidence, state.beside(adopted.candidate), groups(state.now.evidence)
    rank = min(RANK[each.effect.kind] for each in group)
    if RANK[adopted.candidate.effect.kind] == rank and rank != RANK["instrument"]:
        return adopted
    group = [each for each in group if RANK[each.effect.kind] == rank]
    if any(each.effect.added for each in group):
        gains = [_exact_gain(state, adopted, each, effects) for each in group]
    else:
        gains = [gain_of(evidence, each, beside, left_out) for each in group]
    ranked = list(zip(group, gains, strict=True))
    best, order = max(gain for _, gain in ranked), list(state.pool)
    close = (each for each in ranked if each[1] > best - GAIN)
    named = min(close, key=lambda each: order.index(each[0].effect.name))
    return replace(adopted, candidate=named[0], gain=named[1]) if named[0] is not adopted.candidate else adopted


def _exact_gain(state: _State, adopted: Adopted, instead: Candidate, effects: Sequence[Effect]) -> float:
    """Return how well the left-out rows are foretold with another effect in the place of one, bent as it is."""
    others = [each for each in state.adopted if each is not adopted]
    there = _stand(state.subject, [*others, replace(adopted, candidate=instead)], effects)
    fit = fit_linear(there.now.evidence, there.beside(), factor=state.now.linear.factor)
    return held_out(there.now.evidence, fit, groups(there.now.evidence))[0]


def _best_bent(state: _State, effects: Sequence[Effect]) -> _State:
    """Settle at once which of a group it is, where one is not linear: they leave different residuals."""
    if not state.adopted:
        return state
    last = state.adopted[-1]
    group = [last.candidate, *_others(state, last.candidate)]
    if not any(each.effect.added for each in group):
        return state
    renamed = _renamed(state, last, effects)
    return state if renamed is last else _stand(state.subject, (*state.adopted[:-1], renamed), effects)


def _finding(state: _State, adopted: Adopted, tried: int) -> Finding:
    candidate, evidence = adopted.candidate, state.now.evidence
    beside = state.beside(candidate)
    fit, left_out = candidate.fit(evidence, beside), groups(evidence)
    test = significance(evidence, fit)
    ways = len(state.pool[candidate.effect.name])
    log_p = min(test.log_p + np.log(tried * ways), 0.0)
    gain = gain_of(evidence, candidate, beside, left_out)
    aliases = tuple(dict.fromkeys(each.effect.name for each in _others(state, candidate)))
    flipped = sign_flip_p(evidence, candidate, beside)
    is_sure = log_p < ESTABLISHED and gain > GAIN and (flipped is None or flipped <= TOLD)
    confidence: Confidence = "ambiguous" if aliases else "established" if is_sure else "likely"
    effect, columns = candidate.effect, candidate.columns
    told = candidate.term.H.any(axis=0)
    value, std = test.value, np.maximum(test.std, std_of_repeats(evidence, fit, left_out))
    value, std = (value, std) if effect.shown is None else effect.shown(value, std)
    names = tuple(np.array(columns.coefficients)[told].tolist())
    return Finding(
        effect.name, effect.kind, names, value[told], std[told], columns.unit or effect.unit,
        _where(state, candidate), confidence, aliases, effect.separate_by, log_p, gain, columns.shape, flipped,
    )  # fmt: skip


def _where(state: _State, finding: Candidate) -> Mapping[str, object]:
    """Return what a finding is about; of a seating that its pair's other could be instead, both positions."""
    where = dict(finding.columns.where)
    if "position" not in where:
        return where
    evidence, beside = state.now.evidence, state.beside(finding)
    also = [
        way.columns.where["position"]
        for way in state.pool[finding.effect.name]
        if way is not finding and takes_its_place(evidence, finding, way.term, beside)
    ]
    if also:
        where["position"] = [where["position"], *also]
    return where


def _verdict(findings: Sequence[Finding], left: float) -> Verdict:
    if left < UNEXPLAINED:
        return "unexplained"
    for word in ("ambiguous", "likely", "established"):
        if any(each.confidence == word for each in findings):
            return word
    return "consistent"


def _test(tried: Tried) -> Test:
    return Test(tried.candidate.effect.name, tried.test.statistic, tried.log_p, tried.log_p_adjusted)


def _next(findings: Sequence[Finding]) -> str:
    """Say what to measure next."""
    return "; ".join(dict.fromkeys(each.separate_by for each in findings if each.confidence == "ambiguous"))
