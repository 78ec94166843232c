"""Counts of a sine of known amplitude on a slow rate, cut off as a counter cuts them."""

import numpy as np
import pytest

from procedures.diagnosis.sine_between_counts import sine_between, strip_beside

PERIOD, HERTZ = 0.01, 3.7


def counted(amplitude: float, n: int = 400, hertz: float = HERTZ, noise: float = 0.0) -> np.ndarray:
    """Return a running count: a slope of 0.037 a sample, a little bend, a sine."""
    t = np.arange(n) * PERIOD
    exact = 3.7 * t + 0.02 * t**2 + amplitude * np.sin(2 * np.pi * hertz * t + 0.4)
    return np.floor(exact + noise * np.random.default_rng(1).standard_normal(n))


@pytest.mark.parametrize("amplitude", [0.8, 3.0, 20.0])
def test_a_sine_is_bounded_by_its_counts(amplitude: float) -> None:
    found = sine_between(counted(amplitude), HERTZ, PERIOD)
    assert found.strip <= 1.0 + 1e-6
    assert 0 < found.std < 0.15
    assert abs(found.amplitude - amplitude) < 4 * found.std


def test_what_is_no_sine_needs_a_wider_strip_and_has_the_rest_in_its_sigma() -> None:
    rough = sine_between(counted(3.0, noise=2.0), HERTZ, PERIOD)
    assert rough.strip > 5.0
    assert rough.std > rough.strip - 1 - 1e-9


def test_a_sine_that_acts_between_two_samples_is_looked_for_there_alone() -> None:
    n, first, end = 400, 150, 260
    acts = (np.arange(n) >= first) & (np.arange(n) < end)
    t = np.arange(n) * PERIOD
    running = np.stack([np.floor(3.7 * t + acts * (0.4 + 5.0 * np.sin(2 * np.pi * HERTZ * t)))] * 3, axis=1)
    assert strip_beside(running, HERTZ, PERIOD, first, end) == pytest.approx(3.0, abs=1e-6)
    assert strip_beside(running, HERTZ, PERIOD, first - 30, end) > 4.0
    assert strip_beside(running, 2 * HERTZ, PERIOD, first, end) > 6.0
