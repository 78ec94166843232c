"""Marginal likelihoods against scipy's densities and against integrals by quadrature."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, multivariate_t, norm

from procedures.inference.marginal import Held, Member, ranked
from tests.procedures.inference.boards import board

AMPLITUDES = np.geomspace(0.1, 3.0, 25)


def random(seed: int, m: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return 2 * rng.standard_normal(m), rng.standard_normal((m, 2)), rng.standard_normal((m, 3))


def test_members_gain_what_a_normal_density_says() -> None:
    y, A, B = random(1)
    held = Held.of(board(y, [[A], [B]], AMPLITUDES, 0.0), (Member(0, 0.7), Member(1, 1.3)))
    C = np.eye(8) + 0.7**2 * A @ A.T + 1.3**2 * B @ B.T
    expected = multivariate_normal(cov=C).logpdf(y) - multivariate_normal(cov=np.eye(8)).logpdf(y)
    assert held.gain == pytest.approx(expected, rel=1e-10)


def test_of_noise_known_to_few_degrees_of_freedom_it_is_students_t() -> None:
    y, A, B = random(2)
    held = Held.of(board(y, [[A], [B]], AMPLITUDES, 0.0, noise_dof=5.0), (Member(0, 0.7), Member(1, 1.3)))
    C = np.eye(8) + 0.7**2 * A @ A.T + 1.3**2 * B @ B.T
    expected = multivariate_t(shape=C, df=5.0).logpdf(y) - multivariate_t(shape=np.eye(8), df=5.0).logpdf(y)
    assert held.gain == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("noise_dof", [np.inf, 4.0])
def test_an_option_with_a_member_gains_the_mean_over_its_amplitudes(noise_dof: float) -> None:
    y, A, B = random(3)
    one = board(y, [[A], [B]], AMPLITUDES, float(np.log(0.1)), noise_dof)
    found = ranked(one, (Member(0, 0.7),))
    before = Held.of(one, (Member(0, 0.7),)).gain
    gains = [Held.of(one, (Member(0, 0.7), Member(1, s))).gain - before for s in AMPLITUDES.tolist()]
    assert found.total[1] == pytest.approx(np.log(0.1) + np.log(np.mean(np.exp(gains))), rel=1e-10)
    assert found.best[1] == pytest.approx(max(gains), rel=1e-10)


@pytest.mark.parametrize("size", [1e-8, 1.0, 1e8])
def test_an_option_gains_the_same_next_to_one_of_another_size(size: float) -> None:
    """What two columns have in common is judged by their own lengths."""
    y, _, B = random(5)
    apart = size * np.linalg.qr(random(6)[2])[0]
    alone, together = (board(y, [[B], *more], AMPLITUDES, 0.0) for more in ([], [[apart]]))
    assert ranked(together, ()).total[0] == pytest.approx(ranked(alone, ()).total[0], rel=1e-10)


def test_a_coefficient_is_integrated_as_quadrature_does() -> None:
    rng = np.random.default_rng(4)
    y, w = rng.standard_normal(5), rng.standard_normal((5, 1))
    found = ranked(board(y, [[w]], np.array([1.7]), 0.0), ())

    def integrand(c: float) -> float:
        return float(norm.pdf(c, scale=1.7) * np.exp(np.sum(norm.logpdf(y - w[:, 0] * c) - norm.logpdf(y))))

    assert np.exp(found.total[0]) == pytest.approx(quad(integrand, -15, 15)[0], rel=1e-7)


def _exact_log_density(y: np.ndarray, S: np.ndarray) -> float:
    """Return ln N(y; 0, I + S S') by elimination in fractions, rows in their order."""
    m, exact = len(y), [[Fraction(x) for x in row] for row in S]
    C = [[Fraction(sum(a * b for a, b in zip(one, other, strict=True))) for other in exact] for one in exact]
    C = [[C[i][j] + int(i == j) for j in range(m)] + [Fraction(y[i])] for i in range(m)]
    squares, log_det = Fraction(0), 0.0
    for i in range(m):
        pivot = C[i][i]
        log_det += float(np.log(float(pivot)))
        squares += C[i][m] ** 2 / pivot
        for j in range(i + 1, m):
            by = C[j][i] / pivot
            C[j] = [a - by * b for a, b in zip(C[j], C[i], strict=True)]
    return -0.5 * (log_det + float(squares))


def test_columns_of_a_hundred_million_sigma_that_are_nearly_one_lose_no_digits() -> None:
    y, A, _ = random(5)
    first = 1e8 * A[:, :1]
    second = first + 10 * A[:, 1:]  # what the second adds is a ten-millionth of it
    found = ranked(board(y, [[first], [second]], np.array([1.0]), 0.0), (Member(0, 1.0),))
    whole = _exact_log_density(y, np.hstack((first, second)))
    assert found.total[1] == pytest.approx(whole - _exact_log_density(y, first), abs=1e-5)
