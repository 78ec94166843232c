"""A sine planted where it can be worked out by hand: its edges, frequency, amplitude and sigma."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.vibration import measure_vibration

PERIOD, N = 0.01, 600
K = np.array([1000.0, -2000.0, 500.0])  # output per input unit
STRETCH = slice(200, 400)
HUM = 2.0 * (-1.0) ** np.arange(N)  # quiet noise at the highest frequency, of rms 2


def samples(amplitude: FloatArray, hertz: float, first: int = 200, end: int = 400) -> FloatArray:
    t = PERIOD * np.arange(N)
    acts = (np.arange(N) >= first) & (np.arange(N) < end)
    sine = np.sin(2 * np.pi * hertz * t + 0.4) * acts
    return HUM[:, None] + sine[:, None] * amplitude


def gain(hertz: float) -> float:
    """Return the middle between a sample's mean and its value at mid-sample."""
    x = np.pi * hertz * PERIOD
    return (np.sin(x) / x + 1) / 2


@pytest.mark.parametrize("hertz", [7.5, 20.0])
def test_a_sine_in_rates_is_found_as_it_was_planted(hertz: float) -> None:
    amplitude = np.array([300.0, 200.0, 50.0])
    found = measure_vibration(samples(amplitude, hertz), K, PERIOD, STRETCH, cumulative=False)
    assert found.hertz == pytest.approx(hertz)
    assert abs(found.first - 200) <= 5  # edges are tried every fifth of 400 samples
    assert abs(found.end - 400) <= 5
    np.testing.assert_allclose(found.amplitude, amplitude / np.abs(K) / gain(hertz), rtol=0.03)
    x = np.pi * hertz * PERIOD
    half = (1 - np.sin(x) / x) / (1 + np.sin(x) / x)
    by_noise = 2.0 * np.sqrt(2 / (found.end - found.first)) / np.abs(K) / gain(hertz)
    np.testing.assert_allclose(found.std, np.hypot(by_noise, found.amplitude * half), rtol=0.05)


@pytest.mark.parametrize("hertz", [6.0, 12.0])
def test_a_sine_in_counts_is_found_through_the_running_count(hertz: float) -> None:
    t = PERIOD * np.arange(N + 1)
    acts = (np.arange(N + 1) >= 200) & (np.arange(N + 1) < 400)
    a = np.array([25.0, 18.0, 12.0])  # counts, of the running sum
    output = 400.3 * t[:, None] * [1.0, 1.1, 0.9] + acts[:, None] * a * np.sin(2 * np.pi * hertz * t)[:, None]
    counts = np.diff(np.floor(output), axis=0)
    found = measure_vibration(counts, K, PERIOD, STRETCH, cumulative=True)
    assert found.hertz == pytest.approx(hertz, rel=0.02)
    phase = np.pi * hertz * PERIOD
    expected = a * 2 * phase / ((1 + phase / np.sin(phase)) / 2) / np.abs(K)
    np.testing.assert_allclose(found.amplitude, expected, atol=0.5 / np.abs(K).min() * phase, rtol=0.04)
