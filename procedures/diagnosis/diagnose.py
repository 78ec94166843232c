"""The closed loop: residual, effect, model, residual again.

    put right -> evidence -> causes with their probabilities -> parameters solved again with them -> what is left

What is no column of a linear model (a wrong label, a shock, a clock) is put right first; `procedures.inference`
says what else acts; samples at rest are looked at last.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from procedures.anomalies.checks import CheckedCampaigns, check_campaigns
from procedures.anomalies.clock_rate_check import find_clock
from procedures.anomalies.disturbances import find_disturbances, without_disturbances
from procedures.anomalies.disturbed_soaks import without_shocks
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.campaign.campaign import Campaign
from procedures.campaign.dead_channels import without_dead
from procedures.diagnosis.caches import clear_caches
from procedures.diagnosis.declared_effects import declare, declared_effects
from procedures.diagnosis.findings import findings_of, measure_next, not_separable
from procedures.diagnosis.rate_tables import RateTables, SoaksAlone, usable_points
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.term.effect_of_term import TermEffect
from procedures.errors import DoesNotFit, MoveContradicts, NotObservable, ProcedureError
from procedures.evidence.linear_model import LinearFit, fit_linear
from procedures.evidence.refit import Refit
from procedures.evidence.residual_patterns import global_log_p, left_patterns, within_dwells
from procedures.free_positions.rest_detection import motion_within
from procedures.inference.held_out_errors import left_out_groups, residual_rms
from procedures.inference.infer import BaseModel, BenchModel, Inferred, infer
from procedures.inference.priors import PRESENT
from procedures.inference.result import (
    UNEXPLAINED_LOG_P,
    Because,
    BenchAlone,
    Diagnosis,
    EffectTest,
    Finding,
    Reason,
    combine_diagnoses,
    verdict_of,
    with_file_names,
)
from procedures.samples.held_samples import known_scales
from procedures.samples.sample_effects import with_sample_effects
from procedures.uncertainty.budget import with_clock

REPEAT_CAMPAIGN = (
    "the same campaign in another order, on another day: an error that does not repeat is no error term"
)
REPEAT_SOAK = (
    "the same again, with temperature up and down, on another day: an error that does not repeat is no error term"
)


@clear_caches()
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
    quiet = without_shocks(campaigns)
    found = _of_recordings(quiet.campaigns, [one for one in effects if one.name not in names], declared)
    found = replace(_with_found_before(found, quiet.findings, quiet.tests), looked_at=quiet.campaigns)
    return with_sample_effects(found, quiet.campaigns, known_scales(quiet.campaigns, found.solution))


def _with_found_before(found: Diagnosis, findings: Sequence[Finding], tests: Sequence[EffectTest]) -> Diagnosis:
    """Return a diagnosis with what was found before it, which was put right in what it looked at."""
    every, is_left = (*findings, *found.findings), _is_left(found)
    return replace(
        found, verdict=verdict_of(every, is_left=is_left), findings=every, tried=(*tests, *found.tried),
        next_measurement=found.next_measurement or _measure_next(every, is_left=is_left),
    )  # fmt: skip


def _is_left(found: Diagnosis) -> bool:
    return found.verdict in {"partly", "unexplained"}


def _of_recordings(
    campaigns: Sequence[Campaign], effects: Sequence[Effect], declared: Sequence[TermEffect]
) -> Diagnosis:
    """Diagnose rate tables, steps and soaks by their rows."""
    every = (*(one.effect() for one in declared), *effects)
    usable, not_used = usable_points(campaigns)
    tables = RateTables.of(usable)
    of_tables = None if tables is None else with_file_names(_closed(tables, every))
    of_tables = of_tables and _with_found_before(of_tables, not_used, ())
    try:
        found = _of_steps(campaigns, effects, declared)
    except NotObservable:
        disturbed, disturbance_tests = find_disturbances(campaigns)
        campaigns = without_disturbances(campaigns, disturbed)
        if (soaks := SoaksAlone.of(campaigns)) is not None:
            found = _with_found_before(_closed(soaks, every), *find_clock(campaigns))
            found = _with_found_before(found, [each.finding for each in disturbed], disturbance_tests)
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
    findings = (*found_before.findings, *found.findings)
    other_reasons = (*found.other_reasons, *_moving_rests(found.before))
    is_left = _is_left(found) or bool(other_reasons)
    return replace(
        found, verdict=verdict_of(findings, is_left=is_left), findings=findings, other_reasons=other_reasons,
        tried=(*found_before.tests, *found.tried), next_measurement=_measure_next(findings, is_left=is_left),
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
    """Return the base model, without moves, which is reported, where one contradicts its placings."""
    try:
        return BenchModel(steps, fit_reduced(steps))
    except MoveContradicts as error:
        campaigns = tuple(replace(campaign, moves=()) for campaign in steps.campaigns)
        bare = replace(steps, campaigns=campaigns, left_out=(*steps.left_out, f"no transfer is used: {error}"))
        return BenchModel(bare, fit_reduced(bare))


def _closed(subject: BaseModel, effects: Sequence[Effect]) -> Diagnosis:
    """Infer what a base model lacks, and solve it with that in it."""
    found = infer(subject, effects)
    first, now = found.first, found.refit
    findings, unnamed = findings_of(found)
    fits = [_as_is(each) for each in (first, now)]
    left = global_log_p(now.evidence, fits[1])
    is_left = left < UNEXPLAINED_LOG_P or any(each.joint >= PRESENT for each in unnamed)
    stays = [
        within_dwells(each.evidence, fit) if is_left else None
        for each, fit in zip((first, now), fits, strict=True)
    ]
    return Diagnosis(
        verdict_of(findings, is_left=is_left), findings, (),
        residual_rms(first.evidence, now, left_out_groups(first.evidence)), first.fits, now.fits, now.evidence,
        subject.report(first), subject.report(now), left, _measure_next(findings, is_left=is_left),
        unnamed=unnamed, probabilities=found.posterior.probabilities, not_separable=not_separable(found),
        added=(*now.declared, *now.added), values=(*now.declared_values, *now.values),
        unexplained=stays[1], unexplained_before=stays[0],
        left=left_patterns(now.evidence, fits[1]) if is_left else (), on_table=subject.on_table(now),
        declared=declared_effects(now), declared_before=declared_effects(first),
        bench_alone=_bench_alone(found, findings, is_left=is_left),
    )  # fmt: skip


def _as_is(now: Refit) -> LinearFit:
    """Return the fit of a refit's effects with the rows' own sigma."""
    evidence = now.evidence
    return fit_linear(evidence, [each.term for each in now.added], factor=np.ones(len(evidence.residual)))


def _measure_next(findings: Sequence[Finding], *, is_left: bool) -> str:
    """Return what separates the findings' names, or whether what is left comes back; nothing if all is named."""
    measurements = measure_next(findings)
    return REPEAT_CAMPAIGN if is_left and not measurements else measurements


def _bench_alone(found: Inferred, findings: Sequence[Finding], *, is_left: bool) -> BenchAlone | None:
    """Solve with the findings of bench and procedure alone, where one of the instrument is in doubt.

    A calibration claims no effect of the instrument that is in doubt. What was found of the bench stays in it all
    the same: turns that closed worse than stated leave the scale factor as open as they are, whatever else is in
    doubt. None where nothing of the bench was found: then it is the solution without any effect.
    """
    kept = [each for each in found.refit.added if each.effect.kind != "instrument"]
    in_doubt = any(each.kind == "instrument" and each.confidence == "possible" for each in findings)
    if not in_doubt or not kept:
        return None
    with suppress(DoesNotFit):
        now = found.subject.refit(kept)
        left = within_dwells(now.evidence, _as_is(now)) if is_left else None
        return BenchAlone(now.fits, found.subject.report(now), left, declared_effects(now))
    return None
