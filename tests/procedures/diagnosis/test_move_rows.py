"""Moves between placings in a diagnosis: rows as in the solve, and bench effects as the solve's own parameters."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced, report
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.campaign.plan_steps import turn_steps
from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS
from procedures.evidence.candidates import Candidates
from procedures.evidence.linear_model import LinearFit, fit_linear
from procedures.evidence.residual_rows import Evidence, evidence_of
from procedures.inference.infer import BenchModel

PERIOD = 0.02


def campaign(seed: int, effects: dict[str, dict[str, float]] | None = None, *, turns: bool = True) -> Campaign:
    truth = replace(Truth.example(seed), sample_period_s=PERIOD, effects=effects or {})
    return simulate_campaign(
        truth, seed, dwell_s=20.0, turns=turn_steps() if turns else (), move_s=25.0, moves=True, draw_stated=False
    )


@cache
def seen(seed: int = 1) -> tuple[ReducedSteps, CampaignFits, Evidence]:
    steps = reduce_steps([campaign(seed)])
    fits = fit_reduced(steps)
    return steps, fits, evidence_of(fits)


def test_the_fit_with_moves_is_at_the_minimum_of_its_evidence_and_as_sure() -> None:
    _, fits, evidence = seen()
    linear = fit_linear(evidence, [], factor=np.ones(len(evidence.sigma)))
    std = np.sqrt(np.diag(linear.covariance))
    assert np.max(np.abs(linear.theta / std)) < 0.05
    assert fits.gyroscope is not None
    own = np.sqrt(np.diag(fits.gyroscope.joint.fit.covariance))
    np.testing.assert_allclose(std[evidence.columns_of[1]][:12], own[:12], rtol=0.02)
    assert evidence.rows("move").sum() == 3 * 17


PLANTED = [
    ("gyroscope.g_sensitivity", {"xx": 2.0, "yz": -3.0, "zx": 1.5}),
]


def refitted(name: str, sizes: dict[str, float]) -> tuple[Sequence[str], LinearFit, Solution]:
    """Return the coefficients of a planted effect, and what a fit without a turn makes of them."""
    steps = reduce_steps([campaign(3, {name: sizes}, turns=False)])
    fits = fit_reduced(steps)
    way = Candidates(evidence_of(fits), fits, [each for each in EFFECTS if each.name == name])[name][0]
    found = BenchModel(steps, fits).refit([way])
    return way.columns.coefficients, found.linear, report(found.fits)


@pytest.mark.parametrize(("name", "sizes"), PLANTED, ids=lambda each: each if isinstance(each, str) else "")
def test_a_planted_effect_has_its_size_by_moves_without_a_turn(name: str, sizes: dict[str, float]) -> None:
    coefficients, linear, solution = refitted(name, sizes)
    value, covariance = linear.coefficients(0)
    truth = np.array([sizes.get(key, 0.0) for key in coefficients])
    off = (value - truth) / np.sqrt(np.diag(covariance))
    assert np.abs(off).max() < 4
    assert np.abs(value / np.sqrt(np.diag(covariance))).max() > 4
    assert solution.gyroscope is not None
    assert float(linear.white @ linear.white) < 1.5 * float(np.sum(1 - linear.leverage))


def test_a_move_that_contradicts_its_placements_is_left_out_and_reported() -> None:
    made = campaign(4, turns=False)
    one, *others = made.moves
    wrong = replace(one, series=replace(one.series, gyro=np.asarray(one.series.gyro) * 9 // 10))
    found = diagnose([replace(made, moves=(wrong, *others))])
    assert any("no transfer is used" in each for each in found.solution.warnings)
