"""The parts of warm-up by hand: slopes, sensitivities, a thermometer's rate, time constants, what is left."""

import math

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.warm_up import (
    IntervalMeans,
    scatter,
    sensitivity,
    temperature_rate,
    time_constant,
    trend,
    unsettled_bias,
    warm_up,
)

T = 10.0 * np.arange(1, 31)


def test_a_slope_and_its_sigma_are_those_of_a_line() -> None:
    t, noise = np.array([0.0, 10.0, 20.0, 30.0, 40.0]), np.array([2.0, 1.0, 0.5])
    value = np.add(np.outer(t, [3.0, -1.0, 0.0]), [7.0, 8.0, 9.0])
    slope, std = trend(t, value, noise)
    np.testing.assert_allclose(slope, [3.0, -1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(std, noise / math.sqrt(1000.0))


def test_a_sensitivity_is_regressed_with_a_prior_of_the_whole_rate() -> None:
    temperature = np.array([20.0, 21.0, 22.0, 23.0, 24.0])  # squares about the mean: 10 K2
    rate = np.add(np.outer(temperature - 22.0, [0.5, -0.2, 0.0]), [3.0, 4.0, 12.0])  # of size 13
    found, std = sensitivity(temperature, rate, np.array([1.0, 0.1, 10.0]), 0.02)
    prior = 1 / (0.02 * 13.0) ** 2
    weight = 10.0 / np.array([1.0, 0.01, 100.0]) + prior
    np.testing.assert_allclose(std, weight**-0.5)
    np.testing.assert_allclose(found, np.array([0.5 * 10.0, -0.2 * 1000.0, 0.0]) / weight)


def test_scatter_is_the_white_noise_of_a_smooth_course() -> None:
    assert scatter(np.array([1.0, 3.0, 5.0, 7.0, 9.0])) == 0.0
    assert scatter(np.array([0.0, 1.0, 0.0, 1.0])) == pytest.approx(math.sqrt(4 / 6))
    noise = np.random.default_rng(1).normal(0, 0.3, 20000)
    assert scatter(noise + 1e-4 * np.arange(20000)) == pytest.approx(0.3, rel=0.03)


def test_a_thermometers_rate_is_of_its_last_two_minutes() -> None:
    i = np.arange(30)
    temperature = 20.0 + 0.001 * i + 0.029 * np.maximum(i - 18, 0)
    rate, std = temperature_rate(T, temperature)
    assert rate == pytest.approx(0.003)
    assert std == pytest.approx(0.0, abs=1e-12)


def test_a_thermometer_that_steps_is_looked_at_for_longer_and_may_hide_a_step() -> None:
    t = 10.0 * np.arange(1, 81)
    temperature = 20.0 + 0.1 * (np.arange(80) // 25)  # three steps, of which the last 60 means hold two
    rate, std = temperature_rate(t, temperature)
    x, y = t[-60:] - t[-60:].mean(), temperature[-60:]
    assert rate == pytest.approx(x @ y / (x @ x))
    white = np.sqrt(np.mean(np.diff(y, n=2) ** 2) / 6) / np.sqrt(x @ x)
    assert std == pytest.approx(math.hypot(white, 0.1 / 590.0))


@pytest.mark.parametrize("tau", [60.0, 300.0])
def test_a_time_constant_is_the_best_of_those_tried(tau: float) -> None:
    t = 10.0 * np.arange(60)
    found = time_constant(t + 500.0, 3.0 - 5.0 * np.exp(-t / tau), 1e-3)
    assert found == pytest.approx(tau, rel=0.05)  # they are 9 % apart
    assert time_constant(t, 3.0 + 0.01 * t, 1e-3) is None
    assert time_constant(t, 3.0 - 5.0 * np.exp(-t / 1e5), 1e-9) is None  # the longest of those tried


def test_a_time_constant_must_beat_a_line_by_three_sigma() -> None:
    t = 10.0 * np.arange(60)
    value = 1e-2 * np.exp(-t / 100.0)
    A = np.stack((np.ones(60), t), axis=1)
    off = value - A @ np.linalg.lstsq(A, value, rcond=None)[0]
    size = math.sqrt(off @ off) / 3.0
    assert time_constant(t, value, 1.05 * size) is None
    assert time_constant(t, value, 0.95 * size) is not None


def means(gyro: FloatArray, temperature: float | FloatArray = np.nan, std: float = 1.0) -> IntervalMeans:
    n = len(gyro)
    return IntervalMeans(
        T[:n], gyro, np.full((n, 3), std), np.full(n, temperature), gyro / 10, np.full((n, 3), std / 10)
    )


def test_the_limit_is_what_a_dwell_resolves_and_the_drift_is_over_a_pair() -> None:
    gyro = np.add(np.outer(T, [0.01, -0.02, 0.0]), [10.0, 20.0, 30.0])
    found = warm_up(means(gyro), 40.0, 100.0)
    np.testing.assert_allclose(found.gyro_limit, 1.0 * math.sqrt(10.0 / 40.0))
    np.testing.assert_allclose(found.gyro_drift, [1.0, 2.0, 0.0], atol=1e-9)
    assert (found.temperature_rate, found.temperature_limit) == (None, None)
    enough = (48 * 40.0 * 100.0**2) ** (1 / 3)  # 267 s of the 300
    assert not found.is_ready
    steady = warm_up(means(gyro * 0.2), 40.0, 100.0)
    assert (steady.is_ready, steady.left_s) == (True, 0.0)
    early = warm_up(means(gyro[:20] * 0.2), 40.0, 100.0)
    assert not early.is_ready
    assert early.left_s == pytest.approx(enough - 200.0)


def test_the_first_minute_says_nothing_but_when() -> None:
    found = warm_up(means(np.tile([10.0, 20.0, 30.0], (4, 1))), 40.0, 100.0)
    assert (found.is_ready, found.left_s) == (False, 20.0)
    assert np.isnan(found.gyro_drift).all()
    assert warm_up(means(np.tile([10.0, 20.0, 30.0], (1, 1))), 40.0, 100.0).left_s is None
    moved = warm_up(means(np.tile([10.0, 20.0, 30.0], (30, 1))), 40.0, 100.0, marks=(100.0, 260.0))
    assert moved.left_s == pytest.approx(20.0)  # four means begin at or after the mark


def test_what_a_drift_leaves_is_over_the_campaign_and_at_most_a_whole_warm_up() -> None:
    gyro = np.add(np.outer(T - T.mean(), [0.001, -0.002, 0.0]), [30.0, 40.0, 0.0])
    found = unsettled_bias(means(gyro, std=1e-9), 600.0)
    np.testing.assert_allclose(found.gyro, np.array([0.001, 0.002, 0.0]) * 600.0 / math.sqrt(3.0), atol=1e-6)
    long = unsettled_bias(means(gyro, std=1e-9), 1e6)
    np.testing.assert_allclose(long.gyro[:2], 0.1 / 15 * 10.0 * 50.0)
    assert long.accel is not None
    np.testing.assert_allclose(long.accel[:2], 5e-5 * 10.0 * 5.0)
    with pytest.raises(ValueError, match="5 means at rest, expected at least 6"):
        unsettled_bias(means(gyro[:5]), 600.0)
