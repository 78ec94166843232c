import numpy as np
import pytest
from scipy import stats

from procedures.statistics.tail_probabilities import log_chi2_sf, log_f_sf


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
