"""The benchmark's best possible test of a scatter, where its power is known in closed form."""

import numpy as np
import pytest
from scipy import stats

from tests.benchmarks.diagnosing.best_test import power_of


@pytest.mark.parametrize(
    ("sigmas", "directions", "false_alarm"), [(2.8, 3, 1e-2), (4.0, 3, 1e-3), (1.2, 13, 1e-2)]
)
def test_its_power_is_that_of_chi_square_where_all_directions_are_alike(
    sigmas: float, directions: int, false_alarm: float
) -> None:
    threshold = stats.chi2.isf(false_alarm, directions)
    expected = stats.chi2.sf(threshold / (1 + sigmas**2), directions)
    assert power_of(np.full(directions, sigmas), false_alarm) == pytest.approx(expected, abs=0.02)
