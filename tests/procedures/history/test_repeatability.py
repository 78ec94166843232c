"""Turn-on repeatability comes back within its own interval; ageing between clusters does not enter."""

import numpy as np
import pytest

from procedures.history.parameter_series import CalibrationSeries
from procedures.history.repeatability import turn_on_repeatability


def series(rng: np.random.Generator, turn_on: float, ageing: float) -> CalibrationSeries:
    day = np.concatenate([np.sort(rng.uniform(0, 6, 3)) + 365 * year for year in range(4)])
    std = rng.uniform(0.5, 2.0, 12)
    aged = np.repeat(ageing * rng.standard_normal(4), 3)
    return CalibrationSeries(day, aged + turn_on * rng.standard_normal(12) + std * rng.standard_normal(12), std)


@pytest.mark.parametrize("turn_on", [0.0, 3.0, 100.0])
def test_the_interval_covers_what_was_planted(turn_on: float) -> None:
    rng, times = np.random.default_rng(4), 400
    found = [turn_on_repeatability(series(rng, turn_on, 1e3)) for _ in range(times)]
    covered = np.mean([one is not None and one.low_95 <= turn_on <= one.high_95 for one in found])
    expected = 0.95 if turn_on else 0.975  # at 0 the interval has one end only
    assert abs(covered - expected) < 4 * np.sqrt(expected * (1 - expected) / times)
    assert all(one is not None and (one.runs, one.dof) == (12, 8) for one in found)
    if turn_on:
        assert np.median([one.value for one in found if one]) == pytest.approx(turn_on, rel=0.12)


def test_its_sigma_is_that_of_repeated_trials() -> None:
    rng = np.random.default_rng(5)
    found = [turn_on_repeatability(series(rng, 20.0, 0.0)) for _ in range(400)]
    values = [one.value for one in found if one is not None]
    sigmas = [one.std for one in found if one is not None and one.std is not None]
    assert np.std(values) == pytest.approx(np.median(sigmas), rel=0.15)


def test_equal_sigmas_give_the_pooled_standard_deviation_less_their_own() -> None:
    value = np.array([0.0, 6.0, 100.0, 108.0])
    found = turn_on_repeatability(CalibrationSeries(np.array([0.0, 1.0, 300.0, 302.0]), value, np.full(4, 2.0)))
    assert found is not None
    assert found.value == pytest.approx(np.sqrt((18.0 + 32.0) / 2 - 4.0))


def test_calibrations_far_apart_say_nothing_about_it() -> None:
    day = np.array([0.0, 8.0, 400.0])
    assert turn_on_repeatability(CalibrationSeries(day, np.zeros(3), np.ones(3))) is None
