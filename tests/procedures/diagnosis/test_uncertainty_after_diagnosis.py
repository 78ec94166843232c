"""What a diagnosis leaves unexplained or ambiguous widens the uncertainty of the solution."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.validation_campaigns import validate
from procedures.effects import EFFECTS
from procedures.evidence.candidates import Candidate, Candidates
from procedures.evidence.refit import Refit, refit
from procedures.evidence.residual_rows import evidence_of
from procedures.inference.result import Diagnosis, ResidualRms
from procedures.uncertainty import sources
from procedures.uncertainty.budget import ParameterBudget, budget
from procedures.uncertainty.sources import GivenValues, Unexplained
from tests.benchmarks.diagnosing.designs import certified, plain, unit
from tests.procedures.diagnosis.half_explained import by_residual, expanded_bias, half_explained
from tests.procedures.diagnosis.planted import drifting


@cache
def diagnosed(size: float) -> Diagnosis:
    truth = replace(unit(3), slab_tilt_rad=np.zeros(2), faces_rad=np.zeros((6, 2)))
    (campaign,) = certified(truth, 3)
    return diagnose([drifting(campaign, 3, size)])


def bias_x(found: Diagnosis, unexplained: dict[str, Unexplained] | None) -> ParameterBudget:
    wanted = "accelerometer.bias.x"
    return next(one for one in budget(found.after, GivenValues(unexplained=unexplained)) if one.name == wanted)


def test_a_ramp_that_no_effect_explains_widens_the_uncertainty_though_the_means_fit() -> None:
    found = diagnosed(0.02)
    assert found.verdict == "unexplained"
    assert found.unexplained is not None
    assert found.unexplained["accelerometer"].within > 1
    plain, widened = bias_x(found, None), bias_x(found, dict(found.unexplained))
    assert sources.UNEXPLAINED not in {part.source for part in plain.contributions}
    (part,) = [part for part in widened.contributions if part.source == sources.UNEXPLAINED]
    counting = next(part for part in plain.contributions if part.source == sources.COUNTING)
    assert part.std > 0.5 * np.sqrt(found.unexplained["accelerometer"].within) * counting.std
    assert widened.std**2 == pytest.approx(plain.std**2 + part.std**2)


def test_without_it_nothing_is_left_and_nothing_is_added() -> None:
    found = diagnosed(0.0)
    assert found.verdict != "unexplained"
    assert found.unexplained is None


# Two seatings that the data cannot tell apart


def test_parallelism_holds_the_truth_whichever_seating_is_taken() -> None:
    truth = unit(11, effects={"placement.dwell": {"position": 7.0, "x": 3e-4, "z": -3e-4}})
    found = diagnose(plain(truth, 11))
    (seating,) = [each for each in found.findings if each.effect == "placement.dwell"]
    assert set(np.atleast_1d(seating.where["position"])) == {7, 8}
    assert not [each for each in found.findings if each.kind == "instrument" and each.confidence != "possible"]
    faces = truth.faces_rad.reshape(3, 2, 2).sum(axis=1)
    off = (found.solution.parallelism.value - faces) / found.solution.parallelism.std
    assert np.all(np.abs(off) < 4)
    assert found.solution.parallelism.std[1].min() > 5e-5 > 5e-6 > found.solution.parallelism.std[[0, 2]].max()


# A closure error of the bench next to an ambiguous error term


SEED, CLOSURE_DEG = 3, 0.08


def expanded(fits, unexplained) -> np.ndarray:  # type: ignore[no-untyped-def]
    found = {each.name: each.expanded for each in budget(fits, GivenValues(unexplained=unexplained))}
    return np.array([found[f"gyroscope.scale_factor.{axis}"] for axis in "xyz"])


def test_it_does_so_too_where_an_effect_of_the_instrument_is_ambiguous_with_it() -> None:
    """On faces K2 is one with an asymmetry: the calibration carries neither, but its turns stay as loose."""
    planted = {"procedure.closure": {"value": CLOSURE_DEG}, "accelerometer.quadratic": {"x": 5e-5}}
    truth = unit(SEED, effects=planted)
    found = diagnose(certified(truth, SEED))
    in_doubt = [each.effect for each in found.findings if each.kind == "instrument"]
    assert in_doubt == ["accelerometer.quadratic"]
    assert "procedure.closure" in {each.effect for each in found.findings}
    alone = found.bench_alone
    assert alone is not None
    wide, narrow = expanded(alone.fits, alone.unexplained), expanded(found.before, found.unexplained_before)
    off = np.abs(alone.solution.gyroscope.scale_factor.value - truth.gyro_k)
    assert np.all(wide > 3 * narrow)
    assert np.all(off < wide)
    assert np.any(off > narrow)


# A part of an unknown cause that a temperature coefficient absorbed


@pytest.mark.proof
def test_a_pressure_that_a_temperature_coefficient_took_a_part_of_is_in_the_uncertainty_of_the_bias() -> None:
    made = half_explained(16)
    found = diagnose(made.campaigns)
    assert found.verdict == "partly"
    assert found.solution.accelerometer is not None
    off = np.abs(found.solution.accelerometer.bias.value - made.bias_g)
    assert np.any(off > 2 * expanded_bias(found, by_residual(found)))  # the residual alone does not tell
    assert np.all(off < expanded_bias(found, found.unexplained))
    assert np.all(expanded_bias(found, found.unexplained) < 2 * made.size_g)


SIZES = {"accelerometer.quadratic": {"x": 8e-5, "z": -5e-5}, "gyroscope.g_sensitivity": {"xy": 0.8, "zz": -0.5}}
SMALL = 0.1  # sigma: noise is the same draw with the effects in and without


def prepared(effects: dict[str, dict[str, float]]) -> tuple[ReducedSteps, CampaignFits, list[Candidate]]:
    """A unit on a cube whose faces are stated; equal but for the effects, to the last draw."""
    steps = reduce_steps(
        [simulate_campaign(unit(2, effects=effects), 2, certificate_sigma=5e-6, draw_stated=False)]
    )
    base = fit_reduced(steps)
    pool = Candidates(evidence_of(base), base, EFFECTS)
    return steps, base, [pool[name][0] for name in SIZES]


def both(fits: CampaignFits) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """The parameters of each triad and their sigma."""
    assert fits.accelerometer
    assert fits.gyroscope
    joints = (fits.accelerometer, fits.gyroscope.joint)
    return tuple((joint.fit.x, np.sqrt(np.diag(joint.fit.covariance))) for joint in joints)


def solved(effects: dict[str, dict[str, float]]) -> Refit:
    return refit(*prepared(effects))


def test_an_effect_that_was_planted_is_returned_and_the_parameters_are_the_clean_units() -> None:
    found, clean = solved(SIZES), solved({})
    for i, name in enumerate(SIZES):
        value, std = found.values[i] - clean.values[i], np.sqrt(np.diag(found.linear.coefficients(i)[1]))
        keys = "xyz" if len(value) == 3 else [a + b for a in "xyz" for b in "xyz"]
        expected = np.array([SIZES[name].get(key, 0.0) for key in keys])
        assert np.max(np.abs(expected) / std) > 20
        assert np.max(np.abs(value - expected) / std) < 3 * SMALL, name
    for (now, std), (then, _) in zip(both(found.fits), both(clean.fits), strict=True):
        k, b = slice(0, 9), slice(9, 12)
        assert np.max(np.abs(now - then)[k] / std[k]) < 3 * SMALL
        assert np.max(np.abs(now - then)[b] / std[b]) < 3 * SMALL


def test_the_parameters_sigma_grows_by_what_the_coefficients_leave_open() -> None:
    steps, base, added = prepared({})
    for (_, wide), (_, narrow) in zip(both(refit(steps, base, added).fits), both(base), strict=True):
        assert np.min(wide / narrow) > 0.95  # a class that is widened in one only
        assert np.max(wide / narrow) > 1.2


TILTED = {"gyroscope.g_sensitivity": {"xx": 0.15, "yz": -0.15}}


def campaigns(effects: dict[str, dict[str, float]], seed: int) -> tuple[Campaign, ...]:
    """Campaigns of one and the same unit, whatever the seed of the day."""
    return certified(unit(3, effects=effects), seed)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    diagnosis = diagnose(campaigns(TILTED, 3))
    assert "gyroscope.g_sensitivity" in [finding.effect for finding in diagnosis.findings]
    return diagnosis


def dwells(errors: tuple[ResidualRms, ...]) -> ResidualRms:
    return next(each for each in errors if each.quantity == "gyroscope dwells")


def test_the_error_of_another_day_falls_by_an_effect_of_the_unit(found: Diagnosis) -> None:
    errors = dwells(validate(found, campaigns(TILTED, 1003)))
    assert errors.held_out_before is not None
    assert errors.held_out_after is not None
    assert errors.held_out_after < 0.7 * errors.held_out_before
    assert errors.after < 0.7 * errors.before
    assert errors.unit == "deg/h"


def test_it_rises_where_the_effect_is_not_there(found: Diagnosis) -> None:
    errors = dwells(validate(found, campaigns({}, 1003)))
    assert errors.held_out_before is not None
    assert errors.held_out_after is not None
    assert errors.held_out_after > 1.3 * errors.held_out_before
