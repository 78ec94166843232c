"""Labellings of dwells judged by their gyros, beside the multivariate normal distribution itself."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

from procedures.diagnosis.dwell_headings import HeadingLikelihood
from procedures.frames import nominal_C_lb

C_SB = Rotation.from_euler("ZYX", (0.5, 0.2, -0.3)).as_matrix()
TRUE = [*range(1, 13)]
DPH = 1 / 3600.0  # deg/s
SCATTERS = np.array([0.1, 0.4, 1.5, 6.0, 25.0, 100.0]) * DPH
H = np.diag([8.0, -9.0, 10.0]) * DPH  # of North, rates over the largest of K


def likelihood(noise: float = 0.5 * DPH) -> HeadingLikelihood:
    rng, rows = np.random.default_rng(2), np.array([0, 1, 2, *range(4, 12)])
    north = np.array([C_SB @ nominal_C_lb(TRUE[i])[1] for i in rows])
    up = np.array([C_SB @ nominal_C_lb(TRUE[i])[2] for i in rows])
    bias, by_up = np.array([0.3, -0.2, 0.1]), 0.004 * rng.normal(size=(3, 3))
    rate = bias + up @ by_up.T + north @ (1.2 * H).T + noise * rng.normal(size=(11, 3))
    variance = np.tile(noise**2 * np.array([1.0, 1.2, 1.4])[None], (11, 1)) * np.linspace(1, 2, 11)[:, None]
    hours = np.linspace(0.0, 0.9, 11) ** 2
    return HeadingLikelihood(C_SB, rows, rate, variance, hours - hours.mean(), H)


def cost(judge: HeadingLikelihood, labelling: list[int]) -> float:
    """Return the negative log density of all gyros, the coefficients integrated out."""
    C_bl = [nominal_C_lb(labelling[i]).T for i in judge.rows]
    up, north = (np.array([judge.C_sb @ each[:, column] for each in C_bl]) for column in (2, 1))
    totals = []
    for scatter in SCATTERS:
        total = 0.0
        for q in range(3):
            H_q = judge.H[q]
            covariance = np.diag(judge.variance[:, q] + scatter**2) + 1.0**2
            covariance += 0.01**2 * up @ up.T + (0.5 * np.linalg.norm(H_q)) ** 2 * north @ north.T
            covariance += (10.0 * DPH) ** 2 * np.outer(judge.hours, judge.hours)
            total -= multivariate_normal(north @ H_q, covariance).logpdf(judge.rate[:, q])
        totals.append(total)
    return min(totals)


def test_costs_are_negative_log_likelihoods_up_to_a_constant() -> None:
    judge, other = likelihood(), [TRUE, [2, *TRUE[1:]], [1, 1, 4, 4, 5, 6, 8, 8, 9, 10, 12, 11]]
    costs = judge.costs(np.array(other))
    expected = np.array([cost(judge, each) for each in other])
    np.testing.assert_allclose(np.diff(costs), np.diff(expected), rtol=1e-6)
    assert costs[0] - expected[0] == pytest.approx(-16.5 * np.log(2 * np.pi))  # 33 rates


@pytest.mark.parametrize("wrong", [[1, 5], [2, 3, 4]])
def test_the_best_labelling_is_found_one_or_two_dwells_at_a_time(wrong: list[int]) -> None:
    judge = likelihood(0.05 * DPH)
    start = [(p + 1 if p % 2 else p - 1) if i in wrong else p for i, p in enumerate(TRUE)]
    found, margins = judge.best(start)
    kept = [start[i] if i == 3 else p for i, p in enumerate(TRUE)]  # the gyros say nothing of the fourth
    assert found == kept
    assert margins[3] == 0.0
    one = [found[0] + 1, *found[1:]]
    assert margins[0] == pytest.approx(float(np.diff(judge.costs(np.array([found, one])))[0]))
    assert (np.delete(margins, 3) > 0.0).all()
