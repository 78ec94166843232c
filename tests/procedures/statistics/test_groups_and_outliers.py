"""A cube that shifts is found with its size; units that age are not taken for it."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import t as student_t

from procedures.statistics.population import GroupShift, group_shift, judge_fleet, significant

INSIDE = np.array([False, False, True, True])


def fleet(rng: np.random.Generator, units: int, shift: float, walk: float) -> GroupShift:
    """Return the group shift of units calibrated twice with the old cube, then twice with the new one."""
    own = 500.0 * rng.standard_normal((units, 1)) + np.cumsum(walk * rng.standard_normal((units, 4)), axis=1)
    std = rng.uniform(0.5, 2.0, (units, 4))
    value = own + 3.0 * rng.standard_normal((units, 4)) + std * rng.standard_normal((units, 4)) + shift * INSIDE
    found = group_shift(
        np.repeat(np.arange(units), 4).tolist(), np.tile(INSIDE, units), value.ravel(), std.ravel()
    )
    assert found is not None
    return found


@pytest.mark.parametrize("units", [3, 8])
def test_units_that_walk_in_the_meantime_raise_no_false_alarm(units: int) -> None:
    rng, times = np.random.default_rng(units), 1000
    alarms = np.mean([fleet(rng, units, 0.0, walk=5.0).p_value < 0.05 for _ in range(times)])
    assert alarms < 0.05 + 4 * np.sqrt(0.05 * 0.95 / times)


def test_a_planted_shift_comes_back_within_its_own_sigma() -> None:
    rng = np.random.default_rng(9)
    found = [fleet(rng, 12, 20.0, walk=2.0) for _ in range(100)]
    pulls = np.array([(one.shift - 20.0) / one.std for one in found])
    assert abs(pulls.mean()) < 4 / np.sqrt(200)
    assert pulls.std() == pytest.approx(np.sqrt(11 / 9), rel=0.2)  # Student's t, 11 degrees of freedom
    assert np.mean([one.p_value < 1e-3 for one in found]) > 0.95


def test_units_on_one_cube_only_determine_nothing() -> None:
    inside = np.array([True, True, False, False])
    assert group_shift(["a", "b", "c", "d"], inside, np.zeros(4), np.ones(4)) is None
    assert group_shift(["a", "a", "b", "b"], np.tile([True, False], 2), np.zeros(4), np.ones(4)) is None


def paule_mandel(d: np.ndarray, variance: np.ndarray) -> float:
    """Return the variance between units by halving, the scatter about the weighted mean being n - 1."""
    low, high = 0.0, 1e6
    for _ in range(200):
        middle = (low + high) / 2
        mean = np.average(d, weights=1 / (variance + middle))
        low, high = (middle, high) if np.sum((d - mean) ** 2 / (variance + middle)) > len(d) - 1 else (low, middle)
    return low


@pytest.mark.parametrize("scatter", [0.1, 10.0])
def test_shift_sigma_and_p_are_those_of_a_random_effects_mean(scatter: float) -> None:
    """DerSimonian, Laird 1986 with Paule and Mandel's variance; units of two and one calibrations a side."""
    d, first = scatter * np.array([-1.0, 0.2, 1.3, 0.4]), np.array([5.0, 7.0, -3.0, 0.0])
    std = np.array([[1.0, 2.0, 1.5], [0.5, 1.0, 3.0], [2.0, 2.0, 1.0], [1.0, 1.0, 1.0]])
    value = np.stack((first - 0.5, first + 0.5, first + 4.0 + d), axis=1)
    found = group_shift(
        np.repeat(list("abcd"), 3).tolist(), np.tile([False, False, True], 4), value.ravel(), std.ravel()
    )
    assert found is not None
    variance = (std[:, 0] ** 2 + std[:, 1] ** 2) / 4 + std[:, 2] ** 2
    between = paule_mandel(4.0 + d, variance)
    assert (between > 1) == (scatter > 1)
    weight = 1 / (variance + between)
    shift, sigma = np.average(4.0 + d, weights=weight), 1 / np.sqrt(weight.sum())
    assert (found.shift, found.std, found.units) == pytest.approx((shift, sigma, 4), rel=1e-6)
    assert found.p_value == pytest.approx(2 * student_t.cdf(-shift / sigma, 3), rel=1e-6)


# Units that differ from the others


FLEETS, ALPHA = 300, 0.05


@cache
def alarms(n: int, spread: float) -> int:
    """Return in how many fleets of ``n`` equal units one is shown."""
    rng, found = np.random.default_rng(n), 0
    for _ in range(FLEETS):
        std = rng.uniform(0.5, 2.0, n)
        value = spread * rng.standard_normal(n) + std * rng.standard_normal(n)
        found += bool(significant(judge_fleet(value, std).extremes, ALPHA))
    return found


@pytest.mark.parametrize("n", [5, 10, 30])
@pytest.mark.parametrize("spread", [0.0, 100.0])
def test_a_fleet_of_equals_seldom_shows_a_unit(n: int, spread: float) -> None:
    assert alarms(n, spread) / FLEETS < ALPHA + 4 * np.sqrt(ALPHA / FLEETS)


def test_two_units_off_do_not_hide_each_other() -> None:
    rng, found = np.random.default_rng(7), 0
    for _ in range(30):
        std = rng.uniform(0.5, 2.0, 20)
        value = 10.0 * rng.standard_normal(20)
        value[[3, 7]] += 90.0
        found += {one.unit for one in significant(judge_fleet(value, std).extremes, 0.01)} == {3, 7}
    assert found >= 27


def test_the_shift_is_from_the_others_and_few_units_are_not_judged() -> None:
    value, std = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 60.0]), np.full(6, 0.01)
    (off,) = significant(judge_fleet(value, std).extremes, 0.05)
    assert off.unit == 5
    assert off.shift == pytest.approx(60.0, abs=1.0)
    assert judge_fleet(value[:4], std[:4]).extremes == ()
    assert judge_fleet(value[:1], std[:1]).spread is None
