"""Tails of chi-square, F and t, corrections for multiple tests, and outliers of small samples."""

import numpy as np
import pytest
from scipy import stats

from procedures.statistics.significance import (
    TauSums,
    holm,
    log_chi2_sf,
    log_f_sf,
    tail_probabilities,
    tau_levels,
    tau_terms,
    two_sided,
)


@pytest.mark.parametrize("k", [1, 2, 3, 9, 40])
def test_the_tail_of_chi_square_is_scipys_where_that_does_not_underflow(k: int) -> None:
    for chi2 in (0.0, 0.1, 1.0, k, 3.0 * k, 100.0, 600.0):
        assert log_chi2_sf(chi2, k) == pytest.approx(stats.chi2.logsf(chi2, k), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("k", "dof"), [(1, 3.0), (1, 30.0), (3, 12.5), (9, 100.0)])
def test_the_tail_of_f_is_scipys_where_that_does_not_underflow(k: int, dof: float) -> None:
    for f in (0.0, 0.1, 1.0, 5.0, 30.0):
        assert log_f_sf(f, k, dof) == pytest.approx(stats.f.logsf(f, k, dof), rel=1e-8, abs=1e-12)


def test_one_degree_of_freedom_far_out_is_twice_the_normal_tail() -> None:
    for z in (35.0, 100.0, 3000.0):
        assert log_chi2_sf(z**2, 1) == pytest.approx(np.log(2) + stats.norm.logsf(z), rel=1e-9)


def test_two_degrees_of_freedom_are_an_exponential_however_far() -> None:
    for chi2 in (2e3, 1e5, 1e8):
        assert log_chi2_sf(chi2, 2) == pytest.approx(-chi2 / 2, rel=1e-12)


def test_f_far_out_falls_as_a_power_with_half_the_degrees_of_freedom() -> None:
    assert log_f_sf(1e120, 3, 8.0) - log_f_sf(1e100, 3, 8.0) == pytest.approx(-4 * 20 * np.log(10), rel=1e-9)


def test_f_with_infinite_degrees_of_freedom_is_chi_square() -> None:
    assert log_f_sf(500.0, 3, np.inf) == log_chi2_sf(1500.0, 3)
    assert log_f_sf(500.0, 3, 0.99e6) == pytest.approx(log_chi2_sf(1500.0, 3), rel=1e-2)


# Holm's correction for multiple tests


def test_holm_multiplies_by_the_tests_left_and_never_falls() -> None:
    found = holm({"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.005})
    assert found == pytest.approx({"d": 0.02, "a": 0.03, "c": 0.06, "b": 0.06})
    assert list(found) == ["a", "b", "c", "d"]
    assert holm({"a": 0.9, "b": 0.8}) == {"a": 1.0, "b": 1.0}
    assert holm({}) == {}


def test_holm_by_hand() -> None:
    p = dict(enumerate((0.001, 0.015, 0.016, 0.4)))
    by_hand = [0.004, 0.045, 0.045, 0.4]  # 4 x 0.001, 3 x 0.015, the larger of 2 x 0.016 and that, 1 x 0.4
    assert list(holm(p).values()) == pytest.approx(by_hand)
    assert list(holm({0: 0.04, 1: 0.01, 2: 0.03}).values()) == pytest.approx([0.06, 0.03, 0.06])


def test_five_per_cent_of_sets_of_nothing_show_something() -> None:
    rng, sets = np.random.default_rng(1), 2000
    alarms = sum(
        min(holm({i: two_sided(z) for i, z in enumerate(rng.standard_normal(24))}).values()) < 0.05
        for _ in range(sets)
    )
    assert abs(alarms / sets - 0.05) < 4 * np.sqrt(0.05 * 0.95 / sets)


# Against the two limits known in closed form, Student's t and a normal distribution, and against plain sums


VALUES = np.array([1.0, 4.0, 2.5, 7.0, 3.0, 5.5])


def judged(value: float, std: float, own: float) -> tuple[float, float]:
    """Return the probabilities below and above ``value`` by `VALUES`, each with ``std``; its own is ``own``."""
    sigma = np.full(len(VALUES), std)
    tau = tau_levels(np.append(VALUES, value), np.append(sigma, own))
    sums = TauSums(*(each.sum(axis=1, keepdims=True) for each in tau_terms(tau, VALUES, sigma)))
    below, above = tail_probabilities(sums, tau, np.array([value]), np.array([own]))
    return float(below[0]), float(above[0])


@pytest.mark.parametrize("value", [-4.0, 2.0, 6.0, 12.0])
def test_where_scatter_is_all_it_is_students_t(value: float) -> None:
    n, mean, s = len(VALUES), VALUES.mean(), VALUES.std(ddof=1)
    below, above = judged(value, 1e-3, 1e-3)
    t = (value - mean) / (s * np.sqrt(1 + 1 / n))
    assert below == pytest.approx(stats.t.cdf(t, n - 1), rel=0.03)  # the grid of tau is finite
    assert above == pytest.approx(stats.t.sf(t, n - 1), rel=0.03)


@pytest.mark.parametrize("value", [-40.0, 3.0, 60.0])
def test_where_own_errors_are_all_it_is_a_normal_distribution(value: float) -> None:
    std, own = 20.0, 30.0  # the values differ by far less: tau is small, if not nought
    tau = np.array([1e-3])
    sums = TauSums(*(each.sum(axis=1, keepdims=True) for each in tau_terms(tau, VALUES, np.full(6, std))))
    below, above = tail_probabilities(sums, tau, np.array([value]), np.array([own]))
    z = (value - VALUES.mean()) / np.hypot(own, std / np.sqrt(6))
    assert below[0] == pytest.approx(stats.norm.cdf(z), rel=1e-6)
    assert above[0] == pytest.approx(stats.norm.sf(z), rel=1e-6)
