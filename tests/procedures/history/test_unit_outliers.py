"""Units that are off are found, two at once too; a fleet of equals is left alone."""

from functools import cache

import numpy as np
import pytest

from procedures.history.unit_outliers import judge_fleet, significant

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
