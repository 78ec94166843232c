from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.diagnosis import refit as refit_module
from procedures.diagnosis.candidates import Candidate, Candidates
from procedures.diagnosis.linear_model import Term
from procedures.diagnosis.rate_tables import RateTables
from procedures.diagnosis.refit import Refit, refit, refit_with
from procedures.diagnosis.residual_rows import evidence_of
from procedures.effects import EFFECTS
from procedures.effects.effect import Columns
from procedures.effects.term.effect_of_term import Parameter, TermEffect
from tests.benchmarks.diagnosing.designs import unit
from tests.procedures.diagnosis.test_rate_tables import campaign, table

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


def test_the_base_fit_alone_is_many_sigma_off() -> None:
    """What the test above would not see is not there to be seen."""
    (_, planted, _), (_, clean, _) = prepared(SIZES), prepared({})
    for (now, std), (then, _) in zip(both(planted), both(clean), strict=True):
        assert np.max(np.abs(now - then)[:12] / std[:12]) > 5


def test_the_parameters_sigma_grows_by_what_the_coefficients_leave_open() -> None:
    steps, base, added = prepared({})
    for (_, wide), (_, narrow) in zip(both(refit(steps, base, added).fits), both(base), strict=True):
        assert np.min(wide / narrow) > 0.95  # a class that is widened in one only
        assert np.max(wide / narrow) > 1.2


def test_without_effects_it_is_the_base_fit_to_the_last_bit() -> None:
    steps, base, _ = prepared(SIZES)
    assert refit(steps, base, []).fits is base
    assert refit_with(steps, base, [], []).fits is base


def test_given_coefficients_take_off_what_fitted_ones_do() -> None:
    steps, base, added = prepared(SIZES)
    free = refit(steps, base, added)
    given = refit_with(steps, base, added, free.values)
    for (now, std), (then, _) in zip(both(given.fits), both(free.fits), strict=True):
        assert np.max(np.abs(now - then) / std) < SMALL
    data = given.evidence.is_data
    off = given.linear.white * given.linear.factor - free.linear.white * free.linear.factor
    assert np.max(np.abs(off[data])) < SMALL


def test_what_would_leave_its_range_is_held_there_and_the_others_are_fitted_where_it_stands() -> None:
    """A dead zone of 20 deg/s whose width may be 15 at most, against least squares at 15."""
    zone = TermEffect(
        "zone", "gyroscope", ("-u * exp(-(u / w)**4)",), "1", 1e3, "", {"w": Parameter("deg/s", 1.0, 15.0)}
    )
    one, u = table(3), np.tile(np.linspace(-50.0, 50.0, 41), 9)
    output = np.full((len(u), 3), np.nan)
    output[:, 2] = u - u * np.exp(-((u / 20) ** 4)) + 2e-3 * np.random.default_rng(4).standard_normal(len(u))
    tables = RateTables.of(
        [campaign(replace(one, reference=u, output=output, temperature=one.temperature[: len(u)]))]
    )
    assert tables is not None
    first = tables.refit([])
    ways = Candidates(first.evidence, first.fits, [zone.effect()])["gyroscope.zone"]
    found = tables.refit([ways[-1]])
    (way,), (c,) = found.added, found.values
    assert way.columns.nonlinear == {"w": 15.0}
    A = np.stack((u, np.ones(len(u)), -u * np.exp(-((u / 15) ** 4))), axis=1)
    k, _, held = np.linalg.lstsq(A, output[:, 2], rcond=None)[0]
    std = np.sqrt(np.diag(found.linear.coefficients(0)[1]))
    z = way.columns.coefficients.index("z")
    assert c[z] == pytest.approx(held / k, abs=0.05 * std[z])
    assert c[-1] == 0


def test_a_time_constant_moves_by_its_logarithm_a_round_and_stays_in_its_range() -> None:
    (settling,) = (each for each in EFFECTS if each.name == "accelerometer.bias_settling")
    effect, nothing = replace(settling, ranges={"tau_s": (10.0, 1e4)}), np.zeros((4, 2))
    moved = {(100.0, 0.5): 100 * np.exp(0.5), (100.0, 7.0): 100 * np.e, (1e4, 1.0): 1e4, (10.0, -1.0): 10.0}
    for (value, by), expected in moved.items():
        way = Columns(("x", "tau_s"), nonlinear={"tau_s": value})
        candidate = Candidate(effect, way, Term(nothing, np.ones(2)), np.zeros(1, dtype=bool))
        found, c = refit_module._with_nonlinear(candidate, np.array([2.0, by]))  # noqa: SLF001
        assert found.columns.nonlinear["tau_s"] == pytest.approx(expected)
        assert c.tolist() == [2.0, 0.0]
    linear = replace(candidate, columns=Columns(("x",)))
    assert refit_module._with_nonlinear(linear, np.array([2.0]))[0] is linear  # noqa: SLF001
