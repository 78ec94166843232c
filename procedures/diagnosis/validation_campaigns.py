"""Findings put to the test on other campaigns of the unit, which had no part in choosing them.

The coefficients stay as the diagnosis found them; k, E, D and the bench are solved again, without the effects and
with what they add subtracted. Carried over is what belongs to the unit, and to the cube where it is the same one:
a seating, a heading or a slab was that campaign's alone.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from procedures.anomalies.checks import check_campaigns
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import fit_reduced
from procedures.calibration.reduced_steps import reduce_steps
from procedures.campaign.campaign import Campaign
from procedures.campaign.dead_channels import without_dead
from procedures.diagnosis.caches import clear_caches
from procedures.diagnosis.rate_tables import RateTables, SoaksAlone, usable_points
from procedures.errors import DoesNotFit, NotObservable
from procedures.evidence.candidates import Candidate
from procedures.evidence.linear_model import fit_linear
from procedures.evidence.refit import ITERATIONS_WITH_GIVEN_VALUES, Refit, columns_at, refit_with
from procedures.evidence.residual_rows import Evidence, evidence_of
from procedures.inference.held_out_errors import left_out_groups, residual_rms
from procedures.inference.result import Diagnosis, ResidualRms


@clear_caches()
def validate(diagnosis: Diagnosis, campaigns: Sequence[Campaign]) -> tuple[ResidualRms, ...]:
    """Return the errors that other campaigns of the unit show without and with the effects found.

    ``before`` and ``after`` are their residual, ``held_out_*`` the error of each position, turn and rest predicted
    by the others of these campaigns; where none can be predicted, the residual, which was held out of the finding.
    ``after`` is nan where these campaigns cannot be fitted with the effects in.

    Raises
    ------
    NotObservable
        If neither triad can be solved on these campaigns; of a rate table or a soak, if they have none.
    """
    if diagnosis.solution.accelerometer is None and diagnosis.solution.gyroscope is None:
        return _on_tables(diagnosis, campaigns) if diagnosis.on_table else _on_soaks(diagnosis, campaigns)
    alive, _ = without_dead(campaigns)
    steps = reduce_steps(check_campaigns(alive).campaigns)
    base = fit_reduced(steps)
    evidence = evidence_of(base)
    carried = [
        (candidate, value)
        for candidate, value in zip(diagnosis.added, diagnosis.values, strict=True)
        if _is_carried(candidate, diagnosis, campaigns) and _acts(candidate, evidence)
    ]
    try:
        after = refit_with(steps, base, [candidate for candidate, _ in carried], [value for _, value in carried])
    except DoesNotFit:
        without = residual_rms(evidence, refit_with(steps, base, (), ()), left_out_groups(evidence))
        return tuple(replace(_held_out(each), after=np.nan, held_out_after=np.nan) for each in without)
    return tuple(_held_out(each) for each in residual_rms(evidence, after, left_out_groups(evidence)))


def _on_tables(diagnosis: Diagnosis, campaigns: Sequence[Campaign]) -> tuple[ResidualRms, ...]:
    """Return the errors on other rate tables, of a diagnosis of tables alone; their line is fitted again."""
    model = RateTables.of(usable_points(campaigns)[0])
    if model is None:
        raise NotObservable("what a rate table showed", ("a rate table of the same sensor",))
    evidence, fits = model.evidence(), diagnosis.before
    carried = [
        (candidate, value)
        for candidate, value in zip(diagnosis.added, diagnosis.values, strict=True)
        if _is_carried(candidate, diagnosis, campaigns) and _acts(candidate, evidence)
    ]
    now = evidence
    for _ in range(ITERATIONS_WITH_GIVEN_VALUES):
        model = model.without(now, [candidate for candidate, _ in carried], [value for _, value in carried])
        now = model.evidence()
    errors = residual_rms(evidence, Refit(fits, now, fit_linear(now, []), ()), left_out_groups(evidence))
    return tuple(_held_out(each) for each in errors)


def _on_soaks(diagnosis: Diagnosis, campaigns: Sequence[Campaign]) -> tuple[ResidualRms, ...]:
    """Return the errors on other soaks, of a diagnosis that is of soaks alone."""
    soaks = SoaksAlone.of(campaigns)
    if soaks is None:
        raise NotObservable("what moves at rest", ("a long rest or soak",))
    evidence = evidence_of(soaks.fits)
    off = np.zeros(len(evidence.residual))
    for candidate, value in zip(diagnosis.added, diagnosis.values, strict=True):
        if _is_carried(candidate, diagnosis, campaigns) and _acts(candidate, evidence):
            off += evidence.column(columns_at(candidate, evidence)) @ value
    left = replace(evidence, residual=evidence.residual - off)
    after = Refit(soaks.fits, left, fit_linear(left, []), ())
    return tuple(_held_out(each) for each in residual_rms(evidence, after, left_out_groups(evidence)))


def _is_carried(candidate: Candidate, diagnosis: Diagnosis, campaigns: Sequence[Campaign]) -> bool:
    effect = candidate.effect
    cubes = {campaign.fixture.id for campaign in (*diagnosis.before.campaigns, *campaigns)}
    if effect.carried_with == "cube":
        return len(cubes) == 1 and not cubes & {None, ""}
    return effect.kind == "instrument" or effect.carried_with == "unit"


def _acts(candidate: Candidate, evidence: Evidence) -> bool:
    """Say whether what an effect depends on is known in the other campaigns."""
    try:
        H: FloatArray = evidence.column(columns_at(candidate, evidence))
    except DoesNotFit:
        return False
    return bool(np.all(np.isfinite(H)))


def _held_out(errors: ResidualRms) -> ResidualRms:
    if errors.held_out_before is not None and errors.held_out_after is not None:
        return errors
    return replace(errors, held_out_before=errors.before, held_out_after=errors.after)
