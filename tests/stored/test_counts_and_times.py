"""Counts to rates, stamps to times, clocks to lines: numbers of made recordings."""

import numpy as np
import pytest

from procedures.counts.count_kernels import interval_moments
from procedures.counts.count_rate import estimate_counts
from procedures.counts.log_stamps import log_times
from procedures.counts.rate_output_mean import estimate_rates
from procedures.counts.reference_time import fit_clock
from procedures.counts.sample_times import own_period, sample_times
from procedures.statistics.robust_clock_line import fit_earliest_line, fit_time_line
from tests.stored.held import assert_held

PERIOD = 0.01


def counted(rate: float, n: int, seed: int, noise: float = 0.02, bend: float = 0.0) -> np.ndarray:
    """Counts a sample of ``rate`` counts a sample, with noise and a little bend."""
    rng, i = np.random.default_rng(seed), np.arange(n + 1)
    exact = rate * i + bend * i**2 + np.cumsum(noise * rng.standard_normal(n + 1)) + rng.random()
    return np.diff(np.floor(exact)).astype(np.int64)


def test_moments_of_a_normal_cut_to_an_interval_by_quadrature() -> None:
    a, b = np.array([-1.0, 0.3, 3.0, -7.0, 5.0, -0.01]), np.array([0.5, 0.8, 9.0, -6.5, 5.2, 0.01])
    for i, got in enumerate(np.stack(interval_moments(a, b), axis=1)):
        x, w = np.polynomial.legendre.leggauss(80)
        x, w = 0.5 * (a[i] + b[i]) + 0.5 * (b[i] - a[i]) * x, 0.5 * (b[i] - a[i]) * w
        density = w * np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)
        mass = density.sum()
        mean = (density @ x) / mass
        variance = (density @ (x - mean) ** 2) / mass
        assert got == pytest.approx([np.log(mass), mean, variance], rel=1e-6), (a[i], b[i])


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.6])
def test_rates_of_counts(noise: float) -> None:
    dwells = [counted(rate, 800, i, noise) for i, rate in enumerate((10.1234, 0.0021, -3.4, 0.0))]
    starts = [np.array([0]), np.array([0, 300]), np.array([0]), np.array([0])]
    times = [PERIOD * np.arange(1, 801) + (PERIOD * 200 * (np.arange(800) >= 300) if i == 1 else 0.0)
             for i in range(4)]  # fmt: skip
    assert_held("counts", f"rates, noise {noise}", estimate_counts(dwells, PERIOD, starts, times))


def test_rates_of_rates() -> None:
    rng = np.random.default_rng(2)
    smooth = np.convolve(rng.standard_normal(3100), np.ones(5) / 5, "valid")
    dwells = [smooth[:1000] + 3.0, np.round(smooth[1000:2500], 1), smooth[2500:2900]]
    assert_held("counts", "rates of rates", estimate_rates(dwells, PERIOD))


STAMPS = {
    "jitter": lambda t, rng: t + 1e-4 * rng.standard_normal(len(t)),
    "late by chance": lambda t, rng: t + 5e-3 * rng.exponential(size=len(t)),
    "rounded to 4 ms": lambda t, rng: np.floor(t / 4e-3) * 4e-3,
    "in reads of 8": lambda t, rng: np.repeat(t[7::8], 8)[: len(t)],
    "gaps": lambda t, rng: t + 0.5 * (np.arange(len(t)) > 300) + 0.07 * (np.arange(len(t)) > 500),
}


@pytest.mark.parametrize("kind", STAMPS)
@pytest.mark.parametrize("nominal", [0.01, 0.0125])
def test_times_of_samples(kind: str, nominal: float) -> None:
    t = 100.0 + 0.010002 * np.arange(800)
    stamps = STAMPS[kind](t, np.random.default_rng(3))
    assert_held("counts", f"stamps {kind}, {nominal}", [sample_times(stamps, nominal), own_period(stamps)])


def test_times_of_a_log() -> None:
    t = 0.02 * np.arange(600)
    t[[100, 101]] = t[[101, 100]]
    assert_held("counts", "log", log_times(t, 1e-3))


def test_the_rate_of_a_clock() -> None:
    rng, pieces = np.random.default_rng(4), []
    for first in (0.0, 300.0, 700.0):
        t = first + 0.1 * np.arange(500)
        reference = 1.7e9 + t / (1 + 200e-6) + 1e-3 * rng.standard_normal(500) + 5.0 * (first > 500)
        reference[::9] = np.nan
        pieces.append((t, reference))
    assert_held("counts", "clock", fit_clock(pieces))


def test_lines_of_marks() -> None:
    rng = np.random.default_rng(5)
    clock = np.sort(rng.integers(0, 600 * 10**9, 300))
    reference = clock + (clock * 35e-6).astype(np.int64) + (2e6 * rng.exponential(size=300)).astype(np.int64)
    reference[::11] += 40_000_000
    lines = [fit_time_line(clock, reference), fit_earliest_line(clock, reference)]
    assert_held("counts", "lines of marks", lines)
