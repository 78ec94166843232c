"""Counts of a sine of known amplitude on a slow rate, cut off as a counter cuts them."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.sine_between_counts import sine_between, strip_beside
from procedures.diagnosis.vibration import measure_vibration

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


# A sine planted where it can be worked out by hand: its edges, frequency, amplitude and sigma


VIBRATION_PERIOD, VIBRATION_N = 0.01, 600
K = np.array([1000.0, -2000.0, 500.0])  # output per input unit
STRETCH = slice(200, 400)
HUM = 2.0 * (-1.0) ** np.arange(VIBRATION_N)  # quiet noise at the highest frequency, of rms 2


def samples(amplitude: FloatArray, hertz: float, first: int = 200, end: int = 400) -> FloatArray:
    t = VIBRATION_PERIOD * np.arange(VIBRATION_N)
    acts = (np.arange(VIBRATION_N) >= first) & (np.arange(VIBRATION_N) < end)
    sine = np.sin(2 * np.pi * hertz * t + 0.4) * acts
    return HUM[:, None] + sine[:, None] * amplitude


def gain(hertz: float) -> float:
    """Return the middle between a sample's mean and its value at mid-sample."""
    x = np.pi * hertz * VIBRATION_PERIOD
    return (np.sin(x) / x + 1) / 2


@pytest.mark.parametrize("hertz", [7.5, 20.0])
def test_a_sine_in_rates_is_found_as_it_was_planted(hertz: float) -> None:
    amplitude = np.array([300.0, 200.0, 50.0])
    found = measure_vibration(samples(amplitude, hertz), K, VIBRATION_PERIOD, STRETCH, cumulative=False)
    assert found.hertz == pytest.approx(hertz)
    assert abs(found.first - 200) <= 5  # edges are tried every fifth of 400 samples
    assert abs(found.end - 400) <= 5
    np.testing.assert_allclose(found.amplitude, amplitude / np.abs(K) / gain(hertz), rtol=0.03)
    x = np.pi * hertz * VIBRATION_PERIOD
    half = (1 - np.sin(x) / x) / (1 + np.sin(x) / x)
    by_noise = 2.0 * np.sqrt(2 / (found.end - found.first)) / np.abs(K) / gain(hertz)
    np.testing.assert_allclose(found.std, np.hypot(by_noise, found.amplitude * half), rtol=0.05)


@pytest.mark.parametrize("hertz", [6.0, 12.0])
def test_a_sine_in_counts_is_found_through_the_running_count(hertz: float) -> None:
    t = VIBRATION_PERIOD * np.arange(VIBRATION_N + 1)
    acts = (np.arange(VIBRATION_N + 1) >= 200) & (np.arange(VIBRATION_N + 1) < 400)
    a = np.array([25.0, 18.0, 12.0])  # counts, of the running sum
    output = 400.3 * t[:, None] * [1.0, 1.1, 0.9] + acts[:, None] * a * np.sin(2 * np.pi * hertz * t)[:, None]
    counts = np.diff(np.floor(output), axis=0)
    found = measure_vibration(counts, K, VIBRATION_PERIOD, STRETCH, cumulative=True)
    assert found.hertz == pytest.approx(hertz, rel=0.02)
    phase = np.pi * hertz * VIBRATION_PERIOD
    expected = a * 2 * phase / ((1 + phase / np.sin(phase)) / 2) / np.abs(K)
    np.testing.assert_allclose(found.amplitude, expected, atol=0.5 / np.abs(K).min() * phase, rtol=0.04)
