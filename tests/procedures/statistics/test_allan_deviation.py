import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.statistics.allan_deviation import averaging_factors, overlapping_deviation
from tests.refusals import refused


def _nist_1000_points() -> FloatArray:
    """NIST SP 1065 sec. 12.4: the prime modulus generator n(i+1) = 16807 n(i) mod 2147483647."""
    n = [1234567890]
    while len(n) < 1000:
        n.append(16807 * n[-1] % 2147483647)
    return np.array(n) / 2147483647


def test_the_1000_points_of_nist_sp_1065_give_its_printed_deviations() -> None:
    got = overlapping_deviation(_nist_1000_points(), 1.0, np.array([1, 10, 100]))
    printed = [2.922319e-01, 9.159953e-02, 3.241343e-02]  # SP 1065 table 31, overlapping Allan
    assert np.all(np.abs(got.deviation - printed) < 0.5e-6 * 10 ** np.floor(np.log10(printed)) + 1e-12)


def test_the_nbs_14_points_give_their_printed_deviations() -> None:
    data = np.array([892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0])  # SP 1065 table 29
    got = overlapping_deviation(data, 1.0, np.array([1, 2]))
    assert np.all(np.abs(got.deviation - [91.22945, 85.95287]) < 0.5e-5)


def test_white_noise_lies_within_its_limits_as_often_as_stated() -> None:
    rng = np.random.default_rng(1)
    inside, curves = np.zeros(3), 400
    factors = np.array([1, 30, 200])
    for _ in range(curves):
        got = overlapping_deviation(rng.normal(size=2000), 0.02, factors)
        inside += (got.low < 1 / np.sqrt(factors)) & (1 / np.sqrt(factors) < got.high)
    assert np.all(np.abs(inside / curves - 0.95) < 4 * np.sqrt(0.95 * 0.05 / curves))


def test_factors_rise_to_a_quarter_and_too_few_samples_are_refused() -> None:
    assert averaging_factors(5000)[[0, -1]].tolist()[0] == 1
    assert averaging_factors(5000)[-1] <= 1250
    with refused(ValueError, None, "8 samples"):
        overlapping_deviation(np.zeros(8), 1.0)


def _exact_dof(increments_of_phase: FloatArray, m: int) -> float:
    """Return 2 mean^2 / variance of the overlapping estimate for phase L w, w white: traces, no table."""
    n = len(increments_of_phase)
    second = np.zeros((n - 2 * m, n))
    rows = np.arange(n - 2 * m)
    second[rows, rows], second[rows, rows + m], second[rows, rows + 2 * m] = 1.0, -2.0, 1.0
    covariance = second @ increments_of_phase @ increments_of_phase.T @ second.T
    return float(np.trace(covariance) ** 2 / np.sum(covariance**2))


@pytest.mark.parametrize("integrations", [0, 1, 2])  # white phase, white rate, random walk of the rate
def test_degrees_of_freedom_are_those_of_the_quadratic_form(integrations: int) -> None:
    n, factors = 200, np.array([1, 4, 20])
    integral = np.linalg.matrix_power(np.tril(np.ones((n, n))), integrations)
    rate = np.diff(integral @ np.random.default_rng(1).normal(size=n))
    exact = [_exact_dof(integral, int(m)) for m in factors]
    # table 5 of SP 1065 is a fit: here it is 4 % off the exact value at most
    assert overlapping_deviation(rate, 1.0, factors).edf == pytest.approx(exact, rel=0.045)
