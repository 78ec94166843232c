"""A unit switched off and on in the middle of a campaign."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, solve
from procedures.campaign.campaign import Campaign
from procedures.uncertainty.budget import budget
from procedures.units import STANDARD_GRAVITY
from tests.procedures.diagnosis.planted import planted

ACCEL_G, GYRO_DEG_S = np.array([8e-4, -5e-4, 3e-4]), np.array([6e-4, -9e-4, 4e-4])


def switched(seed: int, marked: bool) -> tuple[Truth, Campaign]:
    """Positions 1 to 7 with one turn-on's biases, 8 to 12 and the turns with another's."""
    truth = Truth.example(seed)
    later = replace(truth, accel_d_g=truth.accel_d_g + ACCEL_G, gyro_d_deg_s=truth.gyro_d_deg_s + GYRO_DEG_S)
    one, other = (simulate_campaign(each, seed, dwell_s=30.0) for each in (truth, later))
    on = 2 if marked else 1
    dwells = (*one.dwells[:7], *(replace(dwell, turn_on=on) for dwell in other.dwells[7:]))
    return truth, replace(one, dwells=dwells, turns=tuple(replace(turn, turn_on=on) for turn in other.turns))


@pytest.mark.parametrize("seed", [1])
def test_the_biases_are_parted_and_the_bias_is_the_mean_of_both_with_half_the_step_in_its_sigma(seed: int) -> None:
    truth, campaign = switched(seed, marked=True)
    solution = solve([campaign])
    accel, gyro = solution.accelerometer, solution.gyroscope
    assert accel is not None
    assert gyro is not None
    for found, true in (
        (accel.scale_factor, truth.accel_k),
        (gyro.scale_factor, truth.gyro_k),
    ):
        assert np.all(np.abs(found.value - true) < 4 * found.std)
    for found, true, half in (
        (accel.bias, truth.accel_d_g + ACCEL_G / 2, ACCEL_G / 2),
        (gyro.bias, 3600 * (truth.gyro_d_deg_s + GYRO_DEG_S / 2), 1800 * GYRO_DEG_S),
    ):
        assert np.all(np.abs(found.value - true) < 0.15 * np.abs(half))
        assert found.std == pytest.approx(np.abs(half), rel=0.15)
    assert solution.quality.p_value > 1e-3
    assert any("switched on 2 times" in warning for warning in solution.warnings)


def test_without_the_mark_the_global_test_refuses_what_the_mark_explains() -> None:
    _, campaign = switched(1, marked=False)
    assert solve([campaign]).quality.p_value < 1e-6


# A bias that is new in each step


UNSETTLED = 1e-3 * STANDARD_GRAVITY  # m/s2, far above the noise of a dwell


def test_an_accelerometers_bias_is_known_no_better_than_twelve_draws_determine_and_about_as_one_does() -> None:
    campaign = planted(3)
    stated = replace(campaign, sigma=replace(campaign.sigma, unsettled_accelerometer=UNSETTLED))
    plain, wide = (
        {each.name: each.std for each in budget(fit([one])) if each.unit == "g"} for one in (campaign, stated)
    )
    assert wide.keys() == plain.keys() != set()
    for name, std in wide.items():
        assert 1e-3 / np.sqrt(12) < std < 1.2e-3, name
        assert std > 20 * plain[name]
