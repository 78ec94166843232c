"""The closed loop: residual, effect, model, residual again.

    evidence -> candidates -> one effect at a time -> parameters solved again -> what is left

until nothing significant, plausible and foretelling is left; then every finding is held against what could take
its place, and the whole against noise.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.campaign.dead_channels import without_dead
from procedures.diagnosis.ambiguous_solution import widened_by_alternative
from procedures.diagnosis.bench_alone import bench_alone
from procedures.diagnosis.bias_walk import with_bias_walks
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.checks_before_effects import CheckedCampaigns, check_campaigns
from procedures.diagnosis.clock_rate_check import find_clock
from procedures.diagnosis.declared_effects import declare, declared_effects
from procedures.diagnosis.disturbances import find_disturbances, without_disturbances
from procedures.diagnosis.disturbed_soaks import without_knocks
from procedures.diagnosis.effect_naming import (
    name_findings,
    other_seatings,
    settle_nonlinear,
    with_fixture_channels,
)
from procedures.diagnosis.effect_selection import (
    MAX_EFFECTS,
    MAX_LOG_P,
    TestedEffect,
    has_its_sign,
    log_weight,
    next_effect,
    rank_effects,
    times_plausible,
    too_large_effects,
)
from procedures.diagnosis.enough_explained import (
    DROP_BELOW_LOG_P,
    drop_unexplaining,
    drop_unforetelling,
    in_doubt_where_left,
    left_log_p,
    unwidened_fit,
    without_effect,
)
from procedures.diagnosis.evidence_cache import let_go_at_the_end
from procedures.diagnosis.held_out_errors import left_out_groups, residual_rms
from procedures.diagnosis.held_samples import known_scales
from procedures.diagnosis.left_pattern import LeftPattern, left_patterns
from procedures.diagnosis.model_with_effects import BaseModel, BenchModel, LoopState, solve_with
from procedures.diagnosis.moved_by_curves import with_moved_values
from procedures.diagnosis.outdone import (
    held_against_curves,
    of_one_step_in_doubt,
    steps_beside_steps_in_doubt,
)
from procedures.diagnosis.polynomial_orders import settle_orders
from procedures.diagnosis.rate_tables import RateTables
from procedures.diagnosis.result import (
    UNEXPLAINED_LOG_P,
    Because,
    Diagnosis,
    EffectTest,
    Finding,
    Reason,
    TooLarge,
    combine_diagnoses,
    with_file_names,
)
from procedures.diagnosis.sample_effects import with_sample_effects
from procedures.diagnosis.scatter import tested
from procedures.diagnosis.soaks_alone import SoaksAlone
from procedures.diagnosis.thermal_alternatives import in_doubt_together
from procedures.diagnosis.unexplained_residual import within_dwells
from procedures.diagnosis.verdict import (
    REPEAT_CAMPAIGN,
    REPEAT_SOAK,
    effect_test,
    next_measurement_of,
    verdict_of,
)
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.term.effect_of_term import TermEffect
from procedures.errors import DoesNotFit, MoveContradicts, NotObservable, ProcedureError
from procedures.free_positions.rest_detection import motion_within
from procedures.uncertainty.budget import with_clock
from procedures.uncertainty.sources import ByTriad


@let_go_at_the_end()
def diagnose(
    campaigns: Sequence[Campaign], effects: Sequence[Effect] = EFFECTS, declared: Sequence[TermEffect] = ()
) -> Diagnosis:
    """Find what the residual of one unit's campaigns says the model lacks, and add it.

    ``declared`` effects are in the model of dwells and turns from the start, and tried like others elsewhere. They
    stand before what the catalogue has by their name.

    Raises
    ------
    NotObservable
        If neither triad can be solved, no rate table's sensor either, and nothing rests long enough.
    """
    names = {one.effect().name for one in declared}
    quiet = without_knocks(campaigns)
    found = _of_recordings(quiet.campaigns, [one for one in effects if one.name not in names], declared)
    found = replace(_with_found_before(found, quiet.findings, quiet.tests), looked_at=quiet.campaigns)
    return with_sample_effects(found, quiet.campaigns, known_scales(quiet.campaigns, found.solution))


def _with_found_before(found: Diagnosis, findings: Sequence[Finding], tests: Sequence[EffectTest]) -> Diagnosis:
    """Return a diagnosis with what was found before it, which was put right in what it looked at."""
    every = (*findings, *found.findings)
    return replace(
        found, verdict=verdict_of(every, found.log_p, found.unnamed), findings=every, tried=(*tests, *found.tried)
    )


def _of_recordings(
    campaigns: Sequence[Campaign], effects: Sequence[Effect], declared: Sequence[TermEffect]
) -> Diagnosis:
    """Diagnose rate tables, steps and soaks by their rows."""
    tables, every = RateTables.of(campaigns), (*(one.effect() for one in declared), *effects)
    of_tables = None if tables is None else with_file_names(_closed(tables, every))
    try:
        found = _of_steps(campaigns, effects, declared)
    except NotObservable:
        disturbed, knock_tests = find_disturbances(campaigns)
        campaigns = without_disturbances(campaigns, disturbed)
        if (soaks := SoaksAlone.of(campaigns)) is not None:
            found = _with_found_before(_closed(soaks, every), *find_clock(campaigns))
            found = _with_found_before(found, [each.finding for each in disturbed], knock_tests)
            found = replace(found, next_measurement=found.next_measurement.replace(REPEAT_CAMPAIGN, REPEAT_SOAK))
        elif of_tables is not None:
            return of_tables
        else:
            raise
    return found if of_tables is None else combine_diagnoses(found, of_tables)


def _of_steps(
    campaigns: Sequence[Campaign], effects: Sequence[Effect], declared: Sequence[TermEffect]
) -> Diagnosis:
    """Diagnose dwells, turns and rests, put right first where that is no matter of a linear model."""
    found_before, bench = put_right(campaigns)
    effects = [effect for effect in effects if effect.name not in found_before.settled]
    found = _with_clock(_closed(declare(bench, declared) if declared else bench, effects), found_before.clock)
    findings = with_fixture_channels((*found_before.findings, *found.findings), found.solution_before)
    unnamed = (*found.unnamed, *_moving_rests(found.before))
    verdict = verdict_of(findings, found.log_p, unnamed)
    return replace(
        found, verdict=verdict, findings=findings, unnamed=unnamed,
        tried=(*found_before.tests, *found.tried), next_measurement=next_measurement_of(findings, verdict),
    )  # fmt: skip


def _moving_rests(fits: CampaignFits) -> tuple[Reason, ...]:
    """Return that the rests of the accelerometers move, if they do: no fit to them says so."""
    joint = fits.accelerometer
    if joint is None or joint.rests is None:
        return ()
    moved = motion_within([rest for _, rest in joint.rests.rests.rests], joint.k)
    return () if moved is None else (Reason(Because.MOTION, value=moved),)


def _with_clock(found: Diagnosis, std: float | None) -> Diagnosis:
    """Return a diagnosis whose solutions hold what is not known of the clock by which times were put right."""
    if std is None:
        return found
    before = with_clock(found.solution_before, found.before, std)
    alone = found.bench_alone
    alone = alone and replace(alone, solution=with_clock(alone.solution, alone.fits, std))
    after = with_clock(found.solution, found.after, std)
    return replace(found, solution_before=before, solution=after, clock=std, bench_alone=alone)


def put_right(campaigns: Sequence[Campaign]) -> tuple[CheckedCampaigns, BenchModel]:
    """Return what was put right, and the base model; campaigns that can only be solved as they are stay so."""
    alive, left_out = without_dead(campaigns)
    try:
        before = check_campaigns(alive)
        steps = replace(reduce_steps(before.campaigns), left_out=left_out)
        return before, _bench_model(steps)
    except ProcedureError:
        steps = reduce_steps(campaigns)
        return CheckedCampaigns(tuple(campaigns), (), (), frozenset()), BenchModel(steps, fit_reduced(steps))


def _bench_model(steps: ReducedSteps) -> BenchModel:
    """Return the base model, without moves, which is said, where one contradicts its placings."""
    try:
        return BenchModel(steps, fit_reduced(steps))
    except MoveContradicts as error:
        campaigns = tuple(replace(campaign, moves=()) for campaign in steps.campaigns)
        bare = replace(steps, campaigns=campaigns, left_out=(*steps.left_out, f"no transfer is used: {error}"))
        return BenchModel(bare, fit_reduced(bare))


def _closed(subject: BaseModel, effects: Sequence[Effect]) -> Diagnosis:
    """Add effects to a base model, one at a time, until nothing is left that any of them would explain."""
    state = first = solve_with(subject, (), effects)
    tried = list[TestedEffect]()
    for _ in range(MAX_EFFECTS):
        found = rank_effects(state.now.evidence, state.pool, state.adopted)
        tried = tried or found
        if (grown := _grown(state, found)) is None:
            break
        state = _dropped(settle_orders(settle_nonlinear(grown)))
    state, findings = name_findings(drop_unforetelling(_lasting(drop_unexplaining(state))), len(first.pool))
    findings, unnamed = held_against_curves(state, state.adopted, findings)
    findings = in_doubt_together(state.adopted, findings)
    findings = steps_beside_steps_in_doubt(state, state.adopted, findings)
    left = left_log_p(state)
    if left < DROP_BELOW_LOG_P:
        findings = tuple(in_doubt_where_left(state, *each) for each in zip(state.adopted, findings, strict=True))
    is_left = left < UNEXPLAINED_LOG_P or bool(unnamed)
    findings = of_one_step_in_doubt(state.adopted, findings) if is_left else findings
    unexplained, before, pattern = _unexplained(first, state, findings) if is_left else (None, None, ())
    foretelling, findings = with_bias_walks(state, findings) if is_left else (state.now, findings)
    verdict = verdict_of(findings, left, unnamed)
    return Diagnosis(
        verdict, findings, tuple(effect_test(each) for each in tried),
        residual_rms(first.now.evidence, foretelling, left_out_groups(first.now.evidence)), first.now.fits,
        state.now.fits, state.now.evidence, subject.report(first.now), _reported(state), left,
        next_measurement_of(findings, verdict),
        (*state.now.declared, *(each.candidate for each in state.adopted if not each.candidate.is_of_model)),
        (*state.now.declared_values, *state.now.values),
        unexplained, before, pattern, on_table=subject.on_table(state.now),
        too_large=_too_large(state) if is_left else (), declared=declared_effects(state.now),
        declared_before=declared_effects(first.now),
        bench_alone=bench_alone(state, findings, is_left=is_left), unnamed=unnamed,
    )  # fmt: skip


def _unexplained(
    first: LoopState, state: LoopState, findings: Sequence[Finding]
) -> tuple[ByTriad, ByTriad, tuple[LeftPattern, ...]]:
    """Return what stays of each triad with and without the effects, and where what stays shows."""
    fit, before = unwidened_fit(state), within_dwells(first.now.evidence, unwidened_fit(first))
    return with_moved_values(state, findings, fit), before, left_patterns(state.now.evidence, fit)


def _too_large(state: LoopState) -> tuple[TooLarge, ...]:
    """Return what only its size keeps out of the model where the loop stands, the best first."""
    tried = rank_effects(state.now.evidence, state.pool, state.adopted)
    left_out = left_out_groups(state.now.evidence)
    found = too_large_effects(state.now.evidence, tried, state.adopted, left_out)
    return tuple(TooLarge(each.candidate.effect.name, times_plausible(each)) for each in found)


def _grown(state: LoopState, found: Sequence[TestedEffect]) -> LoopState | None:
    """Adopt the best effect with which the model can be solved; None where none is left."""
    left = list(found)
    while new := next_effect(state.now.evidence, left, state.adopted, left_out_groups(state.now.evidence)):
        both = (*state.adopted, new)
        if new.candidate.is_of_model:
            return replace(state, adopted=both)
        try:
            return state.solved_with(both)
        except DoesNotFit:
            left.remove(new.tried)
    return None


def _reported(state: LoopState) -> Solution:
    """Return what was solved, its sigmas holding the seatings that could be in the place of one."""
    found = state.subject.report(state.now)
    for each in state.adopted:
        for way in other_seatings(state, each.candidate):
            instead = [replace(a, candidate=way) if a is each else a for a in state.adopted]
            with suppress(DoesNotFit):
                found = widened_by_alternative(found, state.subject.report(state.solved_with(instead).now))
    return found


def _dropped(state: LoopState) -> LoopState:
    """Drop an effect that those adopted after it explain."""
    gone = next((each for each in state.adopted[:-1] if _has_gone(state, each.candidate)), None)
    return state if gone is None else without_effect(state, gone)


def _lasting(state: LoopState) -> LoopState:
    """Drop what is no longer seen in the model that it brought about itself, the last adopted first."""
    while gone := next((each for each in reversed(state.adopted) if _has_gone(state, each.candidate)), None):
        state = without_effect(state, gone)
    return state


def _has_gone(state: LoopState, candidate: Candidate) -> bool:
    """Say whether an adopted effect is no longer significant over all that was tried, or a loss that gains."""
    test = tested(state.now.evidence, candidate, state.beside(candidate))
    ways = np.log(len(state.pool)) - log_weight(candidate.effect, state.pool)
    return bool(test.log_p + ways > MAX_LOG_P) or not has_its_sign(candidate, test)
