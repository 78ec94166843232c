"""Labellings of dwells judged by their gyros, beside the multivariate normal distribution itself."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.dwell_headings import HeadingLikelihood, scale_factors_from_turns
from procedures.earth.gravity_and_rate import earth_rate_n
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


@pytest.mark.parametrize("wrong", [[], [0], [1, 5], [2, 3, 4]])
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


@cache
def simulated() -> Campaign:
    return simulate_campaign(Truth.example(7), 7, dwell_s=4.0)


def test_turns_say_the_scale_of_the_gyros_and_their_axes() -> None:
    campaign = simulated()
    K = scale_factors_from_turns(campaign)
    assert K is not None
    truth = Truth.example(7)
    expected = truth.gyro_k[:, None] * truth.gyro_e
    np.testing.assert_allclose(K, expected, atol=0.02 * np.abs(expected).max())


def rates(campaign: Campaign) -> FloatArray:
    series = [each.series for each in campaign.dwells]
    return np.array([np.asarray(each.gyro).sum(axis=0) / (len(each) * each.period) for each in series])


def test_a_campaign_is_judged_over_the_largest_scale_factor() -> None:
    campaign = simulated()
    rate, start = rates(campaign), [each.position for each in campaign.dwells]
    rate[2] = np.nan
    std = np.full(rate.shape, 0.2)
    judge = HeadingLikelihood.of(campaign, rate, std, start)
    K = scale_factors_from_turns(campaign)
    assert judge is not None
    assert K is not None
    size = np.abs(K).max()
    known = [i for i in range(len(start)) if i != 2]
    assert judge.rows.tolist() == known
    np.testing.assert_allclose(judge.rate, rate[known] / size)
    np.testing.assert_allclose(judge.variance, (0.2 / size) ** 2)
    north = np.degrees(earth_rate_n(campaign.site.latitude)[1])
    np.testing.assert_allclose(judge.H, K / size * north)
    middle = np.array([campaign.dwells[i].series.t.mean() / 3600 for i in known])
    np.testing.assert_allclose(judge.hours, middle - middle.mean(), atol=1e-12)


@pytest.mark.parametrize(("told", "judges"), [(5, True), (4, False)])
def test_fewer_than_five_dwells_tell_nothing(told: int, judges: bool) -> None:
    campaign = simulated()
    rate = rates(campaign)
    rate[told:] = np.nan
    start = [each.position for each in campaign.dwells]
    assert (HeadingLikelihood.of(campaign, rate, np.full(rate.shape, 0.2), start) is not None) == judges
