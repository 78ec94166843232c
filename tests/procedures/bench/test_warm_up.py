"""Warm-up of simulated units: 10 count/s are 1 deg/h, noise 3.6 count/sqrt(s), dwells of 100 s, pairs of 290 s."""

import math

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.warm_up import (
    IntervalMeans,
    WarmUpState,
    sensitivity,
    time_constant,
    trend,
    warm_up,
)

WHITE, DPH = 3.6, 10.0
DWELL_S, PAIR_S, TAU_S = 100.0, 290.0, 600.0
LIMIT = WHITE / np.sqrt(DWELL_S)
PER_K = DPH * np.array([0.05, -0.025, 0.015])


def history(
    seed: int, n: int, rise: float = 0.0, *, step: float | None = 1e-3, per_k: FloatArray = PER_K,
    drift: float = 0.0, white: float = WHITE,
) -> IntervalMeans:  # fmt: skip
    """Means of a unit that warms by ``rise`` [K] and drifts [count/s2]; ``step`` [K] of the thermometer."""
    rng, t = np.random.default_rng(seed), 10.0 * np.arange(1, n + 1)
    warmth = rise * (1 - np.exp(-(t - 5) / TAU_S))
    std = np.full((n, 3), white / np.sqrt(10))
    gyro = (
        np.array([80.0, 3.0, 130.0])
        + np.outer(warmth, per_k)
        + drift * t[:, None]
        + std * rng.standard_normal((n, 3))
    )
    accel = np.array([1000.0, 2.0, 3.0]) + np.outer(warmth, [0.02, 0.0, 0.0]) + 1e-3 * rng.standard_normal((n, 3))
    seen = 23 + warmth + 3e-3 * rng.standard_normal(n)
    temperature = np.full(n, np.nan) if step is None else np.round(seen / step) * step
    return IntervalMeans(t, gyro, std, temperature, accel, np.full((n, 3), 1e-3))


def begin_of(means: IntervalMeans, n: int) -> IntervalMeans:
    return IntervalMeans(means.t[:n], means.gyro[:n], means.gyro_std[:n], means.temperature[:n])


def judged(means: IntervalMeans, marks: tuple[float, ...] = ()) -> WarmUpState:
    return warm_up(means, DWELL_S, PAIR_S, marks)


def ready_at(means: IntervalMeans) -> float:
    return next(
        (means.t[n - 1] for n in range(1, len(means.t) + 1) if judged(begin_of(means, n)).is_ready), np.inf
    )


def left_at(seconds: float, rise: float = 10.0) -> float:
    """True drift of the worst gyro over a pair, in limits."""
    return float(rise / TAU_S * np.exp(-seconds / TAU_S) * PER_K[0] * PAIR_S / LIMIT)


@pytest.mark.parametrize("seed", range(2))
def test_a_stable_unit_with_a_thermometer_is_ready_within_a_minute_and_a_half(seed: int) -> None:
    assert ready_at(history(seed, 30)) <= 90.0
    assert ready_at(history(seed, 30, step=0.25)) <= 90.0


@pytest.mark.parametrize("step", [1e-3, 0.25, 1.0, None])
@pytest.mark.parametrize("seed", range(2))
def test_a_warming_unit_is_not_ready_before_its_drift_is_below_its_noise(seed: int, step: float | None) -> None:
    seconds = ready_at(history(seed, 300, 10.0, step=step))
    assert left_at(60.0) > 6
    assert left_at(seconds) < 1
    assert seconds < 2900


def test_without_a_thermometer_readiness_takes_as_long_as_the_noise_does() -> None:
    """The slope's sigma is white sqrt(12 / W^3); times the pair it is half the limit after 739 s."""
    enough = (12 * (2 * PAIR_S) ** 2 * DWELL_S) ** (1 / 3)
    seconds = [ready_at(history(seed, 200, step=None)) for seed in range(5)]
    assert min(seconds) == pytest.approx(enough, abs=10.0)
    assert max(seconds) < 2 * enough
    early = judged(history(0, 30, step=None))
    assert early.left_s == pytest.approx(enough - 300.0)
    assert early.temperature_rate is None


@pytest.mark.parametrize("seed", range(2))
def test_the_time_left_comes_true(seed: int) -> None:
    means = history(seed, 300, 10.0)
    ends = ready_at(means)
    for n in (60, 90, 110):
        left = judged(begin_of(means, n)).left_s
        assert left is not None
        assert abs(10.0 * n + left - ends) < 0.35 * (ends - 10.0 * n) + 60
    assert judged(begin_of(means, 10)).left_s is None  # a minute tells no time constant


def test_a_cube_that_was_moved_begins_again() -> None:
    still, rate = history(3, 60), np.array([0.0, 60.0, -40.0])
    gyro = still.gyro + np.outer(still.t > 300, rate)
    moved = IntervalMeans(still.t, gyro, still.gyro_std, still.temperature)
    assert not judged(moved).is_ready
    assert judged(moved, (100.0, 300.0)).is_ready
    just = judged(moved, (560.0,))
    assert not just.is_ready
    assert just.left_s == pytest.approx(20.0)


# Slopes, sensitivities and time constants by hand


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


@pytest.mark.parametrize("tau", [60.0, 300.0])
def test_a_time_constant_is_the_best_of_those_tried(tau: float) -> None:
    t = 10.0 * np.arange(60)
    found = time_constant(t + 500.0, 3.0 - 5.0 * np.exp(-t / tau), 1e-3)
    assert found == pytest.approx(tau, rel=0.05)  # they are 9 % apart
    assert time_constant(t, 3.0 + 0.01 * t, 1e-3) is None
    assert time_constant(t, 3.0 - 5.0 * np.exp(-t / 1e5), 1e-9) is None  # the longest of those tried
