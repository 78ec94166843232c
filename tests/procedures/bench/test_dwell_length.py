"""The dwell time for a wanted bias: simulated campaigns reach what was asked."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.bench.dwell_length import dwell_seconds
from procedures.calibration.joint_calibration import solve

K = np.full(3, 1e3)


@pytest.mark.parametrize(
    ("k", "noise_g", "wanted"),
    [(1e3, 1e-4, 1.2e-6), (1e5, 1e-5, 1.2e-7)],
)
def test_a_campaign_of_the_length_proposed_has_the_sigma_wanted(k: float, noise_g: float, wanted: float) -> None:
    noise = np.full(3, noise_g * np.sqrt(0.02) * k)
    length = dwell_seconds(noise, np.full(3, k), wanted)
    assert length.is_reached
    std = []
    for seed in range(3):
        truth = Truth.example(seed)
        truth = replace(truth, accel_k=truth.accel_k * k / 1e3, accel_noise_g=noise_g)
        found = solve([simulate_campaign(truth, seed, dwell_s=length.seconds, turns=())]).accelerometer
        assert found is not None
        std.append(found.bias.std)
    rms = float(np.sqrt(np.mean(np.square(std))))
    assert rms == pytest.approx(wanted, rel=0.15)
    assert rms == pytest.approx(length.bias_std_g, rel=0.15)


def test_white_noise_falls_with_the_root_of_the_time_and_the_worst_axis_decides() -> None:
    noise = np.array([0.5, 1.0, 0.2])
    one, half = dwell_seconds(noise, K, 2e-5), dwell_seconds(noise, K, 1e-5)
    assert half.seconds == pytest.approx(4 * one.seconds, abs=20)
    assert one.bias_std_g <= 2e-5
    assert one.seconds == dwell_seconds(np.full(3, 1.0), K, 2e-5).seconds


def test_it_is_rounded_up_and_kept_between_ten_seconds_and_an_hour() -> None:
    assert dwell_seconds(np.full(3, 1e-3), K, 1e-3).seconds == 10
    assert dwell_seconds(np.full(3, 1.0), K, 2.05e-5).seconds % 5 == 0
    far = dwell_seconds(np.full(3, 1.0), K, 1e-7)
    assert far.seconds == 3600
    assert not far.is_reached
    assert far.bias_std_g > 1e-7


def test_a_noiseless_counter_is_limited_by_its_step() -> None:
    length = dwell_seconds(np.zeros(3), K, 1e-8)
    assert length.seconds == 200  # 2e-3 count over 1e3 count/(g s)
