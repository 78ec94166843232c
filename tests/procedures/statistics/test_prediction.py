"""The prediction interval covers the truth; its end at a limit is the date that is said."""

from functools import cache

import numpy as np
import pytest

from procedures.statistics.calibration_drift import (
    MIN_CALIBRATIONS,
    TAIL_PROBABILITY,
    CalibrationSeries,
    NormalMixture,
    ProcessHypotheses,
    filtered,
    forecast,
)
from tests.procedures.statistics.worlds import WORLDS

UNITS = 40


@cache
def covered(name: str, n: int) -> int:
    """Return of how many units of a world the interval after ``n`` calibrations holds the truth."""
    rng, hits = np.random.default_rng(n), 0
    for _ in range(UNITS):
        series, day, truth = WORLDS[name].unit(n, rng)
        found = forecast(series)
        assert found is not None
        predicted = found.at(day)
        hits += predicted.low_95 <= truth <= predicted.high_95
    return hits


@pytest.mark.parametrize("n", [3, 5, 12])
@pytest.mark.parametrize("name", list(WORLDS))
def test_95_per_cent_intervals_cover_at_least_so_many(name: str, n: int) -> None:
    assert covered(name, n) / UNITS > 0.95 - 3 * np.sqrt(0.95 * 0.05 / UNITS)


def test_a_long_trend_is_followed_and_narrow() -> None:
    day = np.linspace(0, 3000, 30)
    std = np.full(30, 1.0)
    series = CalibrationSeries(day, 5.0 + 0.1 * day + np.random.default_rng(1).standard_normal(30), std)
    found = forecast(series)
    assert found is not None
    year_on = found.at(3365.0)
    assert year_on.low_95 < 5.0 + 336.5 < year_on.high_95
    assert year_on.high_95 - year_on.low_95 < 20.0  # of the 36 that the trend makes in that year


def test_the_interval_touches_the_limit_on_the_day_that_is_stated() -> None:
    day = np.linspace(0, 1500, 12)
    series = CalibrationSeries(day, 0.02 * day + np.random.default_rng(2).standard_normal(12), np.ones(12))
    found = forecast(series, low=-50.0, high=50.0)
    assert found is not None
    touch = found.first_touch(list(np.linspace(1500.0, 5150.0, 41)))
    assert touch is not None
    assert found.at(touch).high_95 >= 50.0
    assert found.at(touch - 1.0).high_95 < 50.0
    outside = found.at(touch).outside
    assert outside is not None
    assert TAIL_PROBABILITY <= outside < 2 * TAIL_PROBABILITY


def test_two_calibrations_are_too_few_and_equal_times_are_not() -> None:
    assert forecast(CalibrationSeries(np.arange(2.0), np.zeros(2), np.ones(2))) is None
    found = forecast(
        CalibrationSeries(np.zeros(MIN_CALIBRATIONS), np.zeros(MIN_CALIBRATIONS), np.ones(MIN_CALIBRATIONS))
    )
    assert found is not None
    assert np.isfinite([found.at(0.0).low_95, found.at(400.0).high_95]).all()


# The filter against generalised least squares of all calibrations at once


TURN_ON, WALK, TREND = np.array([2.0, 0.1, 5.0]), np.array([0.1, 0.3, 1e-3]), np.array([0.01, 0.05, 1e-3])
DAY = np.array([0.0, 1.0, 1.0, 200.0, 420.0, 421.0])


def at_once(series: CalibrationSeries, later: float, k: int) -> tuple[float, float, float]:
    """Return mean, sigma, log-likelihood under hypothesis k by generalised least squares, level unknown."""
    t = np.append(series.day, later)
    covariance = WALK[k] ** 2 * np.minimum.outer(t, t) + TREND[k] ** 2 * np.outer(t, t)
    covariance += np.diag(np.append(series.std**2, 0.0) + TURN_ON[k] ** 2)
    own, cross = covariance[:-1, :-1], covariance[-1, :-1]
    weight, one = np.linalg.inv(own), np.ones(len(series))
    level = one @ weight @ series.value / (one @ weight @ one)
    rest = series.value - level
    gain = cross @ weight
    variance = covariance[-1, -1] - gain @ cross + (1 - gain @ one) ** 2 / (one @ weight @ one)
    log = -0.5 * (rest @ weight @ rest + np.linalg.slogdet(own)[1] + np.log(one @ weight @ one))
    return level + gain @ rest, np.sqrt(variance), log


def test_every_hypothesis_predicts_and_weighs_as_generalised_least_squares() -> None:
    rng = np.random.default_rng(1)
    series = CalibrationSeries(DAY, 100.0 + 3.0 * rng.standard_normal(6), rng.uniform(0.5, 2.0, 6))
    found = [
        filtered(series, ProcessHypotheses(*(part[[k]] for part in (TURN_ON, WALK, TREND)))) for k in range(3)
    ]
    expected = [at_once(series, 800.0, k) for k in range(3)]
    for one, (mean, std, _) in zip(found, expected, strict=True):
        mixture = one.at(800.0)
        assert mixture.mean[0] == pytest.approx(mean, rel=1e-10)
        assert mixture.std[0] == pytest.approx(std, rel=1e-8)
    begun = [
        filtered(CalibrationSeries(DAY[:1], series.value[:1], series.std[:1]), one.ways).log_weight[0]
        for one in found
    ]
    gained = np.array([one.log_weight[0] - begin for one, begin in zip(found, begun, strict=True)])
    wanted = np.array([log for _, _, log in expected])
    assert np.diff(gained) == pytest.approx(np.diff(wanted), abs=1e-8)


def test_a_mixtures_quantiles_have_their_probabilities() -> None:
    mixture = NormalMixture(np.array([0.3, 0.7]), np.array([0.0, 50.0]), np.array([1.0, 10.0]))
    for probability in (0.025, 0.3, 0.5, 0.975):
        value = mixture.quantile(probability)
        assert mixture.below(value) == pytest.approx(probability, abs=1e-4)
        assert mixture.above(value) == pytest.approx(1 - probability, abs=1e-4)
