"""A unit switched off and on in the middle of a campaign."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign

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
