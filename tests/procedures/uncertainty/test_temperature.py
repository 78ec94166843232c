"""What temperature moved, on a fit of ten rows whose regression can be written down."""

import numpy as np
import pytest

from procedures.statistics.least_squares import Fit
from procedures.uncertainty.excess_scatter import temperature_effect

ROWS = 10


def fit(residual: np.ndarray) -> Fit:
    """Return a mean of ten rows of unit sigma."""
    return Fit(np.zeros(1), np.array([[1 / ROWS]]), residual, np.ones((ROWS, 1)))


def columns(warm: np.ndarray) -> np.ndarray:
    return np.hstack((warm[:, None], np.zeros((ROWS, 5))))


WARM = np.arange(ROWS) - 4.5  # sum of squares 82.5, and no mean that the fit would absorb


def test_a_residual_that_follows_the_temperature_is_regressed_on_it() -> None:
    residual = 0.6 * WARM
    found = temperature_effect(fit(residual), columns(WARM))
    assert found is not None
    assert found.coefficients == pytest.approx([0.6, 0, 0, 0, 0, 0])
    assert found.covariance[0, 0] == pytest.approx(1 / 82.5)
    assert (found.chi2, found.rank) == (pytest.approx(0.36 * 82.5), 1)
    assert found.dof == pytest.approx(0.18 * 82.5)
    # a parameter that moves with the first row by 2 was moved by 2 x 0.6 x -4.5, known to 9^2 / 82.5
    through = np.zeros((15, ROWS))
    through[3, 0], through[4, 5] = 2.0, 0.1
    variance = found.variance(through)
    assert variance[3] == pytest.approx(5.4**2 - 81 / 82.5)
    assert variance[4] == pytest.approx((0.06 * 0.5) ** 2 - 0.05**2 / 82.5)
    assert np.all(variance[[0, 1, 2, *range(5, 15)]] == 0.0)


def test_what_noise_does_once_in_a_hundred_times_is_no_effect() -> None:
    # chi-square of one coefficient: 6.635 at one in a hundred
    for chi2, counts in ((6.6, False), (6.7, True)):
        residual = np.sqrt(chi2 / 82.5) * WARM
        assert (temperature_effect(fit(residual), columns(WARM)) is not None) == counts


def test_a_variance_is_never_less_than_zero_and_what_the_fit_absorbs_determines_nothing() -> None:
    found = temperature_effect(fit(0.6 * WARM), columns(WARM))
    assert found is not None
    across = np.zeros((15, ROWS))
    across[0, [0, 9]] = [1.0, 1.0]  # by as much up as down
    assert found.variance(across)[0] == 0.0
    assert temperature_effect(fit(np.ones(ROWS)), columns(np.ones(ROWS))) is None
    assert temperature_effect(fit(0.6 * WARM), None) is None
    assert temperature_effect(fit(0.6 * WARM), np.zeros((ROWS, 6))) is None
