import numpy as np
import pytest
from scipy import stats

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.fit_without_rows import without_rows
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import (
    Term,
    coefficients_beside,
    fit_linear,
    predict_left_out,
    significance,
)
from procedures.diagnosis.residual_rows import Evidence
from procedures.statistics.tail_probabilities import log_chi2_sf
from tests.procedures.diagnosis.redrawn import made_up, redrawn, seen_by, small


def brute(evidence: Evidence, term: Term, keep: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Minimise the weighted rows ``keep`` and the coefficients' prior by normal equations."""
    D = np.hstack((evidence.A, -term.H))[keep] / evidence.sigma[keep, None]
    y = evidence.residual[keep] / evidence.sigma[keep]
    prior = np.concatenate((np.zeros(evidence.A.shape[1]), 1 / term.plausible**2))
    C = np.linalg.inv(D.T @ D + np.diag(prior))
    return -C @ D.T @ y, C


def small_with_term(seed: int) -> tuple[Evidence, Term]:
    rng = np.random.default_rng(seed)
    evidence = small(rng)
    return evidence, Term(rng.standard_normal((36, 2)), np.array([0.1, 5.0]))


def test_coefficients_have_the_covariance_of_normal_equations() -> None:
    evidence, term = small_with_term(1)
    fit = fit_linear(evidence, [term], factor=np.ones(36))
    theta, C = brute(evidence, term, np.arange(36))
    np.testing.assert_allclose(fit.theta, theta, atol=1e-10)
    np.testing.assert_allclose(fit.covariance, C, atol=1e-10)
    np.testing.assert_allclose(fit.coefficients()[0], theta[-2:], atol=1e-10)


def test_held_out_is_what_really_leaving_each_group_out_and_fitting_again_gives() -> None:
    evidence, term = small_with_term(2)
    fit = fit_linear(evidence, [term], factor=np.ones(36))
    left_out = left_out_groups(evidence)
    total, errors = predict_left_out(evidence, fit, left_out)
    expected = 0.0
    for rows in left_out:
        theta, C = brute(evidence, term, np.setdiff1d(np.arange(36), rows))
        D = np.hstack((evidence.A, -term.H))[rows]
        error = evidence.residual[rows] + D @ theta
        V = np.eye(len(rows)) + D @ C @ D.T
        np.testing.assert_allclose(errors[rows], error, atol=1e-9)
        expected -= 0.5 * (error @ np.linalg.solve(V, error) + np.linalg.slogdet(V)[1])
    assert total == pytest.approx(expected, rel=1e-9)


def test_a_fit_less_some_rows_is_the_fit_without_them() -> None:
    evidence, term = small_with_term(4)
    fit = fit_linear(evidence, [term], factor=np.ones(36))
    rows: IntArray = np.arange(9, 12)
    theta, C = brute(evidence, term, np.setdiff1d(np.arange(36), rows))
    got = without_rows(fit, rows)
    np.testing.assert_allclose(got.theta, theta, atol=1e-9)
    np.testing.assert_allclose(got.covariance, C, atol=1e-9)


@pytest.mark.parametrize("name", ["accelerometer.relaxation", "gyroscope.magnetic"])
def test_p_of_what_is_not_there_is_uniform(name: str) -> None:
    _, evidence, pool = seen_by("certified")
    way, rng = pool[name][0], np.random.default_rng(5)
    tests = [significance(new, way.fit(new)) for new in (redrawn(evidence, rng) for _ in range(150))]
    k = len(way.term.plausible)
    joint = [np.exp(log_chi2_sf(t.statistic * k, k)) for t in tests]
    assert stats.kstest(joint, "uniform").pvalue > 1e-3
    p = np.exp([t.log_p for t in tests])  # of two looks, the lesser twice: never less than uniform by much
    assert stats.kstest(p, "uniform", alternative="greater").pvalue > 1e-3
    assert np.mean(p < 0.5) > 0.15


def test_p_is_uniform_too_where_the_variance_had_to_be_widened() -> None:
    rng, p = np.random.default_rng(6), []
    for _ in range(400):
        evidence = small(rng)
        evidence.residual[:] *= 3.0
        fit = made_up(evidence, rng.standard_normal((36, 1)), size=1e4).fit(evidence)
        assert fit.factor[0] > 1.5
        assert fit.dof[0] == pytest.approx(26, abs=0.01)
        told = significance(evidence, fit)
        assert told.dof == pytest.approx(26, abs=0.01)  # 36 rows less 10 parameters
        p.append(np.exp(told.log_p))
    assert stats.kstest(p, "uniform").pvalue > 1e-3


@pytest.mark.parametrize("name", ["accelerometer.quadratic", "fixture.face_tilt", "placement.dwell"])
def test_coefficients_beside_another_term_are_those_of_fitting_both(name: str) -> None:
    _, evidence, pool = seen_by("certified")
    first, other = pool["accelerometer.scale_asymmetry"][0], pool[name][0].term
    alone = first.fit(evidence)
    ((c, C),) = coefficients_beside(evidence, alone, [other])
    both = fit_linear(evidence, [first.term, other], factor=alone.factor)
    expected, covariance = both.coefficients(0)
    std = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(c / std, expected / std, atol=1e-6)
    np.testing.assert_allclose(C / np.outer(std, std), covariance / np.outer(std, std), atol=1e-6)
