"""Noise, spectra, tails, lines and the history of a unit: made data, numbers of scipy where it has them."""

import numpy as np
import pytest
from scipy.stats import chi2, f

from procedures.earth.gravity_and_rate import earth_rate_n, normal_gravity
from procedures.history.control_chart import control_chart, control_limit
from procedures.history.drift_models import filtered, hypothesis_grid
from procedures.history.group_shifts import group_shift
from procedures.history.parameter_series import CalibrationSeries
from procedures.history.prediction import forecast, last_predictable_day
from procedures.history.repeatability import clusters, turn_on_repeatability
from procedures.history.unit_outliers import judge_fleet, significant
from procedures.statistics.allan_deviation import averaging_factors, overlapping_deviation
from procedures.statistics.line_with_correlated_errors import fit_correlated_line
from procedures.statistics.multiple_testing import holm, two_sided
from procedures.statistics.noise_terms import fit_noise
from procedures.statistics.spectrum import lines_of, spectrum_of, without_lines
from procedures.statistics.tail_probabilities import log_chi2_sf, log_f_sf
from procedures.statistics.white_noise import white_noise
from tests.stored.held import assert_held

PERIOD = 0.02


def noisy(n: int = 20_000, walk: float = 2e-3, quantum: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(1)
    quantised = np.diff(rng.uniform(-0.5, 0.5, n + 1)) * quantum / PERIOD
    sine = 0.5 * np.sin(2 * np.pi * 7.31 * PERIOD * np.arange(n))
    return rng.standard_normal(n) + np.cumsum(walk * rng.standard_normal(n)) + quantised + sine


@pytest.mark.parametrize("quantum", [0.0, 0.5])
def test_allan_deviation_and_its_terms(quantum: float) -> None:
    rate = noisy(quantum=quantum)
    curve = overlapping_deviation(rate, PERIOD)
    for i in (0, 3, 12):  # IEEE 952: overlapping, of averages over m samples
        m = round(curve.tau[i] / PERIOD)
        sums = np.convolve(rate, np.ones(m), "valid") / m
        expected = np.sqrt(np.mean((sums[m:] - sums[:-m]) ** 2) / 2)
        assert curve.deviation[i] == pytest.approx(expected, rel=1e-9)
    held = [curve, fit_noise(curve, quantum), averaging_factors(20_000)]
    assert_held("statistics", f"noise, quantum {quantum}", held)


def test_a_spectrum_and_its_lines() -> None:
    rate = noisy()
    lines = lines_of(rate, PERIOD)
    left = without_lines(rate, PERIOD, lines)
    held = [spectrum_of(rate, PERIOD), lines, left, white_noise(np.stack([left] * 3, axis=1), PERIOD)]
    assert_held("statistics", "spectrum", held)


@pytest.mark.parametrize(("x", "k", "dof"), [(0.5, 1, 3.0), (5.0, 3, 12.5), (60.0, 4, 40.0), (900.0, 2, 900.0)])
def test_tails_are_those_of_scipy_and_go_on_where_it_ends(x: float, k: int, dof: float) -> None:
    assert log_chi2_sf(x, k) == pytest.approx(chi2.logsf(x, k), rel=1e-6)
    assert log_f_sf(x, k, dof) == pytest.approx(f.logsf(x, k, dof), rel=1e-6)
    assert_held("statistics", f"far tails {x}", [log_chi2_sf(100 * x, k), log_f_sf(100 * x, k, dof)])


def test_a_line_whose_errors_hang_together_and_one_that_bends() -> None:
    rng = np.random.default_rng(3)
    x, group = np.linspace(0, 10, 60), np.repeat([0, 1, 2], 20)
    y = 2.0 + 0.3 * x + 0.1 * np.cumsum(rng.standard_normal(60)) + 0.05 * rng.standard_normal(60)
    held = [fit_correlated_line(x, y, group), fit_correlated_line(x, y, group, 0.5)]
    held += [holm({"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.5}), two_sided(2.5)]
    assert_held("statistics", "lines", held)


def test_the_history_of_a_unit() -> None:
    rng = np.random.default_rng(6)
    day = np.array([0.0, 1.0, 2.0, 200.0, 201.0, 420.0, 640.0, 641.0, 900.0, 1300.0, 1301.0, 1600.0])
    value = 100.0 + 0.02 * day + 3.0 * rng.standard_normal(12)
    series = CalibrationSeries(day, value, rng.uniform(0.5, 2.0, 12))
    found = forecast(series, low=80.0, high=150.0)
    assert found is not None
    process = filtered(series, hypothesis_grid(series))
    assert_held("statistics", "history", {
        "at": [found.at(later) for later in (1700.0, 2400.0)], "process": [process.at(2000.0), process.log_weight],
        "touch": found.first_touch(list(np.linspace(1600.0, 5000.0, 41))), "last": last_predictable_day(day),
        "chart": control_chart(series, control_limit(24)), "turn on": turn_on_repeatability(series),
        "clusters": clusters(day),
    }, (".at.value",))  # fmt: skip


def test_a_fleet() -> None:
    rng = np.random.default_rng(7)
    value, std = np.append(rng.standard_normal(15), 9.0), rng.uniform(0.2, 0.9, 16)
    fleet = judge_fleet(value, std)
    shift = group_shift(np.repeat(np.arange(4), 4).tolist(), np.tile([False, False, True, True], 4), value, std)
    assert_held("statistics", "fleet", [fleet, significant(fleet.extremes, 0.05), shift])


def test_gravity_is_that_of_wgs84_and_the_earth_turns_once_a_day() -> None:
    for latitude in (0.0, 0.7, -1.2):
        s = np.sin(latitude) ** 2
        at_sea = 9.7803253359 * (1 + 0.00193185265241 * s) / np.sqrt(1 - 0.00669437999014 * s)
        assert normal_gravity(latitude) == pytest.approx(at_sea, rel=1e-9)
        expected = 7.292115e-5 * np.array([0.0, np.cos(latitude), np.sin(latitude)])
        assert earth_rate_n(latitude) == pytest.approx(expected, rel=1e-9, abs=1e-20)
    assert_held("statistics", "gravity above the sea", [normal_gravity(0.7, h) for h in (-300.0, 500.0, 8000.0)])
