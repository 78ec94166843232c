"""A campaign of a unit that was not given the time to settle, and says so: its sigmas widen as they must."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import fit, solve
from procedures.calibration.solution_values import Estimate, Solution
from procedures.campaign.campaign import Campaign
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY

RISE_K, TAU_S, GYRO_PER_K, ACCEL_PER_K = 10.0, 300.0, 0.05, 2e-5
TO_GO = RISE_K * np.sqrt(TAU_S / (2 * 1140.0))  # K, root mean square over the 1140 s that it lasts


@cache
def warming(seed: int) -> tuple[Truth, Campaign]:
    """A unit that warms up to 25 degC, where its truth is told, while it is being calibrated."""
    rng, truth = np.random.default_rng(seed), Truth.example(seed)
    effects = {
        "gyroscope.bias_temperature": dict(zip("xyz", GYRO_PER_K * rng.standard_normal(3), strict=True)),
        "accelerometer.bias_temperature": dict(zip("xyz", ACCEL_PER_K * rng.standard_normal(3), strict=True)),
    }
    truth = replace(
        truth, accel_k=1e5 * truth.accel_k, gyro_k=1e3 * truth.gyro_k, effects=effects,
        temperature_start_c=25 - RISE_K, temperature_rise_k=RISE_K, temperature_tau_s=TAU_S,
    )  # fmt: skip
    return truth, simulate_campaign(truth, seed, dwell_s=20.0)


def stated(campaign: Campaign, share: float = 1.0) -> Campaign:
    sigma = replace(
        campaign.sigma,
        unsettled_gyro=share * TO_GO * GYRO_PER_K * RAD_S_PER_DEG_H,
        unsettled_accelerometer=share * TO_GO * ACCEL_PER_K * STANDARD_GRAVITY,
    )
    return replace(campaign, sigma=sigma)


def scores(solution: Solution, truth: Truth) -> FloatArray:
    """Errors of k and D of both triads in their own sigma, (4, 3)."""
    accel, gyro = solution.accelerometer, solution.gyroscope
    assert accel is not None
    assert gyro is not None
    pairs: list[tuple[Estimate, FloatArray]] = [
        (accel.scale_factor, truth.accel_k),
        (accel.bias, truth.accel_d_g),
        (gyro.scale_factor, truth.gyro_k),
        (gyro.bias, truth.gyro_d_deg_s * 3600),
    ]
    return np.array([(estimate.value - true) / estimate.std for estimate, true in pairs])


def test_what_is_stated_covers_the_error_that_the_drift_makes() -> None:
    silent, reported = [], []
    for seed in range(6):
        truth, campaign = warming(seed)
        silent.append(scores(solve([campaign]), truth))
        reported.append(scores(solve([stated(campaign)]), truth))
    rms_silent, rms = (np.sqrt(np.mean(np.square(z), axis=(0, 2))) for z in (silent, reported))
    assert rms_silent[1] > 50  # the accelerometers' bias: counting noise knows nothing of drift
    assert np.all(rms < 1.5)
    assert rms[1] > 0.3  # nor is it as wide as the sky
    assert np.abs(reported).max() < 5


def test_the_residual_is_then_what_was_expected() -> None:
    _, campaign = warming(1)
    assert solve([campaign]).quality.p_value < 1e-6
    solution = solve([stated(campaign)])
    assert solution.quality.p_value > 0.01
    assert not [w for w in solution.warnings if "residual" in w]


def test_misalignment_and_both_ends_of_every_step_widen_too() -> None:
    _, campaign = warming(2)
    before, after = solve([campaign]), solve([stated(campaign)])
    for triad in ("accelerometer", "gyroscope"):
        wide, narrow = getattr(after, triad), getattr(before, triad)
        assert np.all(
            wide.misalignment.std[~np.eye(3, dtype=bool)] > narrow.misalignment.std[~np.eye(3, dtype=bool)]
        )
        assert np.all(wide.bias.std > narrow.bias.std)
    sigma = {(r.name, r.triad): r.sigma for r in before.residuals}
    wider = [r for r in after.residuals if np.all(r.sigma > sigma[r.name, r.triad])]
    assert {r.kind for r in wider} == {"dwell", "turn"}


def test_a_turn_is_as_uncertain_as_the_bias_that_is_taken_off_it() -> None:
    fits = fit([stated(warming(3)[1], 3.0)])
    assert fits.gyroscope is not None
    joint = fits.gyroscope.joint
    assert np.all(joint.excess == 0)  # less scatter than was stated
    k = np.linalg.norm(joint.K, axis=1)  # count/deg
    drift = 3 * TO_GO * GYRO_PER_K / 3600 * k
    for turn, sigma in zip(fits.gyroscope.turns, fits.gyroscope.turn_sigma, strict=True):
        assert sigma == pytest.approx(np.hypot(turn.std, drift * turn.seconds), rel=1e-3)
    assert joint.sigma == pytest.approx(np.hypot(joint.seen.std, drift), rel=1e-3)


def test_only_the_campaign_that_says_so_loses_weight() -> None:
    """Joined with a settled campaign, the unsettled one adds next to nothing and spoils nothing."""
    truth = replace(warming(4)[0], effects={})
    settled = simulate_campaign(truth, 44, dwell_s=20.0)
    alone, both = solve([settled]), solve([settled, stated(warming(4)[1], 30.0)])
    for solution in (alone, both):
        assert np.abs(scores(solution, truth)[0]).max() < 4
    assert alone.accelerometer is not None
    assert both.accelerometer is not None
    assert both.accelerometer.scale_factor.std == pytest.approx(alone.accelerometer.scale_factor.std, rel=0.05)
