import numpy as np
import pytest

from procedures.statistics.least_squares import Fit, minimise


def linear(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.standard_normal((40, 5)), rng.standard_normal(40), np.array([1.0, 10.0, 0.1, 1e3, 1e-3])


@pytest.mark.parametrize("seed", range(2))
def test_a_linear_problem_gives_its_normal_equations(seed: int) -> None:
    A, y, scale = linear(seed)
    A = A / scale  # parameters as large as their scales
    fit = minimise(lambda x: A @ x - y, np.zeros(5), scale)
    exact = np.linalg.inv(A.T @ A)
    assert np.all(np.abs(fit.x - exact @ A.T @ y) < 1e-9 * np.sqrt(np.diag(exact)))  # rounding of differences
    assert np.allclose(
        fit.covariance, exact, rtol=1e-8, atol=1e-9 * np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    )
    assert fit.chi2 == pytest.approx(np.sum((A @ exact @ A.T @ y - y) ** 2), rel=1e-10)
    assert fit.dof == 35


def test_a_bent_problem_is_solved_to_its_minimum() -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0, 2, 50)
    y = 3 * np.exp(-1.5 * t) + 1e-3 * rng.standard_normal(50)
    fit = minimise(lambda x: (x[0] * np.exp(-x[1] * t) - y) / 1e-3, np.array([2.0, 1.0]), np.ones(2))
    slope = fit.jacobian.T @ fit.residual  # the gradient, in sigma: zero at the minimum
    assert np.all(np.abs(fit.covariance @ slope) < 1e-3 * np.sqrt(np.diag(fit.covariance)))
    assert np.all(np.abs(fit.x - [3, 1.5]) < 4 * np.sqrt(np.diag(fit.covariance)))


def test_a_held_parameter_leaves_the_others_their_sigma() -> None:
    """A row 1e9 times stiffer than the rest, as a held perpendicularity is: (q - s p) / HELD."""
    held, share = 1e-9, -0.25
    wide = minimise(
        lambda x: np.array([x[0] / 1.4e-3, (x[1] - share * x[0]) / held]), np.zeros(2), np.full(2, 0.1)
    )
    assert np.sqrt(np.diag(wide.covariance)) == pytest.approx([1.4e-3, 1.4e-3 * abs(share)], rel=1e-3)


def mean_of(values: list[float]) -> Fit:
    return minimise(lambda x: x[0] - np.array(values), np.zeros(1), np.ones(1))


def test_the_birge_ratio_is_one_until_chi_square_is_too_large() -> None:
    # nine degrees of freedom: chi-square exceeds 16.919 once in 20 times, 21.666 once in 100 (tables)
    for chi2, p_value, wider in ((16.9, 0.05, False), (17.0, 0.05, True), (21.6, 0.01, False), (21.7, 0.01, True)):
        fit = mean_of([np.sqrt(chi2 / 10) * sign for sign in 5 * (1.0, -1.0)])
        expected = np.sqrt(chi2 / 9) if wider else 1.0
        assert fit.birge_ratio(10, p_value) == pytest.approx(expected, rel=1e-9)
