"""What is computed of recordings: rates of counts, times of stamps, noise terms, spectra, a unit's history."""

import numpy as np
import pytest

from procedures.counts.count_rate import estimate_counts
from procedures.counts.dwell_means import estimate_rates
from procedures.counts.reference_time import fit_clock
from procedures.counts.sample_times import own_period, sample_times
from procedures.statistics.allan_deviation import fit_noise, overlapping_deviation
from procedures.statistics.calibration_drift import (
    CalibrationSeries,
    control_chart,
    control_limit,
    forecast,
    turn_on_repeatability,
)
from procedures.statistics.population import judge_fleet
from procedures.statistics.spectrum import lines_of, spectrum_of
from tests.stored.conftest import StoredResult

PERIOD = 0.01


def counted(rate: float, n: int, seed: int, noise: float) -> np.ndarray:
    rng, i = np.random.default_rng(seed), np.arange(n + 1)
    exact = rate * i + np.cumsum(noise * rng.standard_normal(n + 1)) + rng.random()
    return np.diff(np.floor(exact)).astype(np.int64)


@pytest.mark.parametrize("noise", [0.02, 0.6])
def test_rates_of_counts(stored_result: StoredResult, noise: float) -> None:
    dwells = [counted(rate, 800, i, noise) for i, rate in enumerate((10.1234, 0.0021, -3.4, 0.0))]
    starts = [np.array([0]), np.array([0, 300]), np.array([0]), np.array([0])]
    gap = PERIOD * 200 * (np.arange(800) >= 300)
    times = [PERIOD * np.arange(1, 801) + (gap if i == 1 else 0.0) for i in range(4)]
    stored_result.check(estimate_counts(dwells, PERIOD, starts, times))


def test_means_of_rates(stored_result: StoredResult) -> None:
    smooth = np.convolve(np.random.default_rng(2).standard_normal(3100), np.ones(5) / 5, "valid")
    dwells = [smooth[:1000] + 3.0, np.round(smooth[1000:2500], 1), smooth[2500:2900]]
    stored_result.check(estimate_rates(dwells, PERIOD))


STAMPS = {
    "jitter": lambda t, rng: t + 1e-4 * rng.standard_normal(len(t)),
    "late by chance": lambda t, rng: t + 5e-3 * rng.exponential(size=len(t)),
    "rounded to 4 ms": lambda t, rng: np.floor(t / 4e-3) * 4e-3,
    "in reads of 8": lambda t, rng: np.repeat(t[7::8], 8)[: len(t)],
}


def test_times_of_samples_by_their_stamps(stored_result: StoredResult) -> None:
    t, found = 100.0 + 0.010002 * np.arange(800), {}
    for kind, stamp in STAMPS.items():
        stamps = stamp(t, np.random.default_rng(3))
        found[kind] = [sample_times(stamps, 0.01), own_period(stamps)]
    stored_result.check(found)


def test_the_rate_of_a_clock_over_three_pieces_and_a_step(stored_result: StoredResult) -> None:
    rng, pieces = np.random.default_rng(4), []
    for first in (0.0, 300.0, 700.0):
        t = first + 0.1 * np.arange(500)
        reference = 1.7e9 + t / (1 + 200e-6) + 1e-3 * rng.standard_normal(500) + 5.0 * (first > 500)
        reference[::9] = np.nan
        pieces.append((t, reference))
    stored_result.check(fit_clock(pieces))


def test_allan_deviation_noise_terms_and_spectral_lines(stored_result: StoredResult) -> None:
    rng, n, period = np.random.default_rng(1), 20_000, 0.02
    quantised = np.diff(rng.uniform(-0.5, 0.5, n + 1)) * 0.5 / period
    sine = 0.5 * np.sin(2 * np.pi * 7.31 * period * np.arange(n))
    rate = rng.standard_normal(n) + np.cumsum(2e-3 * rng.standard_normal(n)) + quantised + sine
    curve = overlapping_deviation(rate, period)
    stored_result.check({
        "curve": curve, "terms": fit_noise(curve, 0.5), "spectrum": spectrum_of(rate, period),
        "lines": lines_of(rate, period),
    })  # fmt: skip


def test_the_history_of_a_unit_and_its_fleet(stored_result: StoredResult) -> None:
    rng = np.random.default_rng(6)
    day = np.array([0.0, 1.0, 2.0, 200.0, 201.0, 420.0, 640.0, 641.0, 900.0, 1300.0, 1301.0, 1600.0])
    value = 100.0 + 0.02 * day + 3.0 * rng.standard_normal(12)
    series = CalibrationSeries(day, value, rng.uniform(0.5, 2.0, 12))
    found = forecast(series, low=80.0, high=150.0)
    assert found is not None
    fleet = judge_fleet(np.append(rng.standard_normal(15), 9.0), rng.uniform(0.2, 0.9, 16))
    stored_result.check({
        "at": [found.at(later) for later in (1700.0, 2400.0)],
        "touch": found.first_touch(list(np.linspace(1600.0, 5000.0, 41))),
        "chart": control_chart(series, control_limit(24)), "turn on": turn_on_repeatability(series),
        "fleet": fleet,
    })  # fmt: skip
