from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import evidence_of
from procedures.effects.effect import Columns
from tests.benchmarks.diagnosing.designs import certified, unit
from tests.procedures.diagnosis.redrawn import seen_by

SEEDS = range(3)


@cache
def _solved(seed: int) -> tuple[ReducedSteps, CampaignFits]:
    steps = reduce_steps(certified(unit(seed), seed))
    return steps, fit_reduced(steps)


def test_a_base_fit_is_at_the_minimum_of_its_own_evidence() -> None:
    _, evidence, _ = seen_by("certified")
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.sigma)))
    std = np.sqrt(np.diag(fit.covariance))
    own = np.isin(np.arange(len(std)), evidence.columns_of[0])
    assert np.max(np.abs(fit.theta[own] / std[own])) < 0.05
    assert np.max(np.abs(fit.theta / std)) < 1.0  # the gyroscopes' part met the accelerometers' slab and faces


@pytest.mark.parametrize("number", [5, 9])
def test_the_accelerometers_fit_moves_by_what_the_design_says_of_a_parameter(number: int) -> None:
    """Rates moved by what a step of a parameter foretells move that parameter by the step, and no other."""
    steps, base = _solved(1)
    before, evidence = base.accelerometer, evidence_of(base)
    assert before is not None
    assert steps.accel is not None
    std = np.sqrt(np.diag(before.fit.covariance))
    k = np.linalg.norm(before.K, axis=1)
    column = evidence.A[evidence.rows("mean", triad="accelerometer"), evidence.columns_of[0][number]]
    moved = -column.reshape(-1, 3) * k * 5 * std[number]
    assert np.any(moved)
    after = fit_reduced(replace(steps, accel=replace(steps.accel, rate=steps.accel.rate + moved))).accelerometer
    assert after is not None
    expected = np.zeros(len(std))
    expected[number] = 5.0
    np.testing.assert_allclose((after.fit.x - before.fit.x) / std, expected, atol=0.02)


@pytest.mark.parametrize("number", [4, 9])
def test_the_gyroscopes_fit_moves_by_what_the_design_says_of_dwells_and_turns(number: int) -> None:
    steps, base = _solved(1)
    assert base.gyroscope is not None
    assert steps.gyro is not None
    before, evidence = base.gyroscope.joint, evidence_of(base)
    std = np.sqrt(np.diag(before.fit.covariance))
    k = np.linalg.norm(before.K, axis=1)
    foretold = -evidence.A[:, evidence.columns_of[1][number]] * 5 * std[number]
    means = foretold[evidence.rows("mean", triad="gyroscope")].reshape(-1, 3) * k
    totals = foretold[evidence.rows("turn")].reshape(-1, 3) * k
    assert np.any(means)
    assert np.any(totals)
    place = {id(turn.record): i for i, turn in enumerate(base.gyroscope.turns)}
    turns = tuple(replace(turn, total=turn.total + totals[place[id(turn.record)]]) for turn in steps.turns)
    gyro = replace(steps.gyro, rate=steps.gyro.rate + means)
    after = fit_reduced(replace(steps, gyro=gyro, turns=turns)).gyroscope
    assert after is not None
    expected = np.zeros(len(std))
    expected[number] = 5.0
    np.testing.assert_allclose((after.joint.fit.x - before.fit.x) / std, expected, atol=0.05)


def test_a_turn_adds_up_and_an_output_belongs_to_its_triad() -> None:
    _, evidence, _ = seen_by("certified")
    n = len(evidence.excitation.t)
    constant = np.zeros((n, 3, 1))
    constant[:, 1] = 2.0
    H = evidence.column(Columns(("c",), gyro=constant))[:, 0]
    turns, means = evidence.rows("turn"), evidence.rows("mean")
    seconds = np.array(
        [w.w.sum() for w in evidence.weights if evidence.kind[w.rows.start] == evidence.kind[turns][0]]
    )
    np.testing.assert_allclose(H[turns & (evidence.axis == 1)], 2 * seconds)
    assert np.all(seconds > 10)
    np.testing.assert_allclose(H[means & (evidence.triad == 1) & (evidence.axis == 1)], 2.0)
    assert not H[(evidence.triad == 0) | (evidence.axis != 1)].any()


def test_whitened_residuals_of_sound_campaigns_have_unit_variance() -> None:
    squares: dict[str, list[float]] = {}
    for seed in SEEDS:
        evidence = evidence_of(_solved(seed)[1])
        fit = fit_linear(evidence, [], factor=np.ones(len(evidence.sigma)))
        free = 1 - fit.leverage
        for kind in ("mean", "slope", "curvature", "turn"):
            for triad in ("accelerometer", "gyroscope"):
                rows = evidence.rows(kind, triad=triad)
                if rows.any():
                    squares.setdefault(f"{triad} {kind}", []).extend(
                        [float(np.sum(fit.white[rows] ** 2)), float(np.sum(free[rows]))]
                    )
    for name, sums in squares.items():
        chi2, dof = sum(sums[::2]), sum(sums[1::2])
        assert abs(chi2 - dof) < 4.5 * np.sqrt(2 * dof), f"{name}: chi-square {chi2:.1f} of {dof:.1f}"
