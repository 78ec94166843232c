"""The control chart alarms as often as it says, and sees a jump and a drift."""

import numpy as np
import pytest
from scipy.stats import norm, t

from procedures.statistics.calibration_drift import (
    MIN_EARLIER,
    CalibrationSeries,
    control_chart,
    control_limit,
    turn_on_repeatability,
)


def unit(rng: np.random.Generator, n: int, turn_on: float, std: float = 1.0) -> CalibrationSeries:
    own = std * rng.uniform(0.5, 2.0, n)
    value = turn_on * rng.standard_normal(n) + own * rng.standard_normal(n)
    return CalibrationSeries(100.0 * np.arange(n), value, own)


def test_where_turn_on_scatter_is_all_z_is_that_of_students_t() -> None:
    value = np.random.default_rng(1).standard_normal(8)
    chart = control_chart(CalibrationSeries(np.arange(8.0), value, np.full(8, 1e-3)), 3.0)
    assert chart is not None
    for i in range(MIN_EARLIER, 8):
        past = value[:i]
        score = (value[i] - past.mean()) / (past.std(ddof=1) * np.sqrt(1 + 1 / i))
        assert chart.z[i - MIN_EARLIER] == pytest.approx(norm.ppf(t.cdf(score, i - 1)), abs=0.03)


@pytest.mark.parametrize("turn_on", [0.0, 1.0, 50.0])
def test_a_steady_unit_raises_no_more_alarms_than_the_limit_says(turn_on: float) -> None:
    rng, units, limit = np.random.default_rng(2), 1000, 2.0  # a low limit, to have alarms to count
    charts = [control_chart(unit(rng, 10, turn_on), limit) for _ in range(units)]
    z = np.array([chart.z for chart in charts if chart is not None])
    ewma = np.array([chart.ewma / chart.ewma_std for chart in charts if chart is not None])
    reported = 2 * norm.sf(limit)
    for found in (z, ewma):
        sigma = np.sqrt(reported / z.size) * (2 if found is ewma else 1)  # neighbours of an average are alike
        assert np.mean(np.abs(found) > limit) < reported + 4 * sigma
    if turn_on == 50.0:
        assert np.mean(np.abs(z) > limit) == pytest.approx(reported, abs=4 * np.sqrt(reported / z.size))


def test_a_jump_is_an_alarm_at_once() -> None:
    steady = unit(np.random.default_rng(3), 30, 3.0)
    jump = CalibrationSeries(steady.day, steady.value + 40.0 * (np.arange(30) == 20), steady.std)
    chart = control_chart(jump, control_limit(24))
    assert chart is not None
    assert np.flatnonzero(np.abs(chart.z) > chart.limit).tolist() == [20 - MIN_EARLIER]


def test_a_slow_creep_is_an_alarm_of_the_average_long_before_one_of_the_values() -> None:
    rng, seen, units = np.random.default_rng(3), np.zeros(2), 40
    for _ in range(units):
        steady = unit(rng, 30, 3.0)
        creep = CalibrationSeries(steady.day, steady.value + np.maximum(np.arange(30) - 15, 0), steady.std)
        chart = control_chart(creep, control_limit(24))
        assert chart is not None
        of_value, of_average = np.abs(chart.z), np.abs(chart.ewma / chart.ewma_std)
        seen += [(one > chart.limit).any() for one in (of_value, of_average)]
    assert seen[1] > 0.85 * units > 0.5 * units > seen[0]


def test_two_calibrations_make_no_chart() -> None:
    assert control_chart(CalibrationSeries(np.arange(2.0), np.zeros(2), np.ones(2)), 3.0) is None


# Turn-on repeatability


def series(rng: np.random.Generator, turn_on: float, ageing: float) -> CalibrationSeries:
    day = np.concatenate([np.sort(rng.uniform(0, 6, 3)) + 365 * year for year in range(4)])
    std = rng.uniform(0.5, 2.0, 12)
    aged = np.repeat(ageing * rng.standard_normal(4), 3)
    return CalibrationSeries(day, aged + turn_on * rng.standard_normal(12) + std * rng.standard_normal(12), std)


@pytest.mark.parametrize("turn_on", [0.0, 3.0, 100.0])
def test_the_interval_covers_what_was_planted(turn_on: float) -> None:
    rng, times = np.random.default_rng(4), 400
    found = [turn_on_repeatability(series(rng, turn_on, 1e3)) for _ in range(times)]
    covered = np.mean([one is not None and one.interval_95[0] <= turn_on <= one.interval_95[1] for one in found])
    expected = 0.95 if turn_on else 0.975  # at 0 the interval has one end only
    assert abs(covered - expected) < 4 * np.sqrt(expected * (1 - expected) / times)
    assert all(one is not None and (one.turn_ons, one.dof) == (12, 8) for one in found)
    if turn_on:
        assert np.median([one.std for one in found if one]) == pytest.approx(turn_on, rel=0.12)


def test_equal_sigmas_give_the_pooled_standard_deviation_less_their_own() -> None:
    value = np.array([0.0, 6.0, 100.0, 108.0])
    found = turn_on_repeatability(CalibrationSeries(np.array([0.0, 1.0, 300.0, 302.0]), value, np.full(4, 2.0)))
    assert found is not None
    assert found.std == pytest.approx(np.sqrt((18.0 + 32.0) / 2 - 4.0))


def test_calibrations_far_apart_say_nothing_about_it() -> None:
    day = np.array([0.0, 8.0, 400.0])
    assert turn_on_repeatability(CalibrationSeries(day, np.zeros(3), np.ones(3))) is None
