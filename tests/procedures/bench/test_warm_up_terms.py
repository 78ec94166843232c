"""The parts of warm-up by hand: slopes, sensitivities, a thermometer's rate, time constants, what is left."""

import math

import numpy as np
import pytest

from procedures.bench.warm_up import (
    sensitivity,
    time_constant,
    trend,
)


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
