"""Against the two limits known in closed form, Student's t and a normal distribution, and against plain sums."""

import numpy as np
import pytest
from scipy import stats

from procedures.statistics.small_sample_outlier import (
    TauSums,
    tail_probabilities,
    tau_levels,
    tau_terms,
)

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
