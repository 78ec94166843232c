"""Worst case, distribution, the way back to tolerances, and what else would help."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import ITEMS, STACK
from procedures.tolerance.estimator_errors import (
    ToleranceShape,
    ToleranceUnit,
    draw_errors,
    draw_tilts,
    estimator_errors,
    tilt_std,
)
from procedures.tolerance.improvements import remedies, remedy_gain
from procedures.tolerance.tolerances_for_accuracy import (
    AccuracyUnreachable,
    all_errors,
    allowed_tolerances,
    cheapest_items,
    worst_case,
    worst_corner,
)
from tests.procedures.test_tolerance import IDEAL, P1_ITEMS, PAPER, random_case
from tests.refusals import refused

QUIET = 1e-5 / np.sqrt(5000)  # g: a dwell of P1
WEIGHT = np.ones(len(ITEMS))
items_of = st.lists(st.floats(1e-6, 2e-4), min_size=11, max_size=11).map(np.array)


def test_the_worst_12_position_error_is_the_sum_of_all_tilts_that_face_it() -> None:
    """By hand, an aligned unit: (3 + 5 + 3 + 5, 1 + 3 + 3 + 5, 1 + 3 + 3 + 5) theta / 6."""
    worst = worst_case(all_errors(IDEAL)).largest(P1_ITEMS)[:3]
    assert worst == pytest.approx(1e-4 * np.array([16, 12, 12]) / 6, rel=2e-4)  # cosines: 2 theta of it


@settings(max_examples=20)
@given(items_of, st.integers(0, 5))
def test_no_corner_and_no_drawn_cube_is_worse_than_the_bound(item: FloatArray, seed: int) -> None:
    unit, _ = random_case(seed)
    quantity = all_errors(unit)
    worst, corner = worst_case(quantity).largest(item), worst_corner(quantity, item)
    third = 100 * float((STACK @ item).max()) ** 3 + 1e-13
    assert np.all(corner <= worst + third)
    drawn = quantity(draw_tilts(np.random.default_rng(seed), item, 2000))
    assert np.all(np.abs(drawn).max(axis=1) <= worst + third)
    assert np.all(corner[:3] > 0.99 * worst[:3])  # of a linear error the bound is the worst case itself


@pytest.mark.parametrize(("shape", "share"), [("uniform", 1 / 3), ("normal", 1 / 4)])
def test_the_12_position_error_scatters_as_its_items_do(shape: ToleranceShape, share: float) -> None:
    """First order: variance = sum over the four faces across of a tilt's variance, over 36."""
    sample = draw_errors(P1_ITEMS, IDEAL, 40_000, 7, shape)
    variance = np.array([1, 3, 3, 5, 3, 5]) * 1e-8 * share / 2  # of each tilt: items on the way, two directions
    assert tilt_std(P1_ITEMS, shape) ** 2 == pytest.approx(variance)
    across = np.array([variance[[2, 3, 4, 5]].sum(), variance[[0, 1, 4, 5]].sum(), variance[[0, 1, 2, 3]].sum()])
    got = np.mean(sample.bias[0] ** 2, axis=1)
    assert got == pytest.approx(across / 36, rel=4 * np.sqrt(3 / 40_000))  # kurtosis of at most 4


@pytest.mark.parametrize(("estimator", "wanted"), [(0, 1e-4), (1, 1e-6), (2, 5e-8)])
def test_allowed_tolerances_meet_the_accuracy_and_no_other_cube_is_cheaper(estimator: int, wanted: float) -> None:
    asked = worst_case(lambda tilts: estimator_errors(tilts, PAPER).bias[estimator])
    weight = np.linspace(1, 2, 11)
    best = cheapest_items(asked, wanted, weight)
    assert asked.largest(best).max() == pytest.approx(wanted, rel=1e-6)
    rng = np.random.default_rng(5)
    for _ in range(200):
        other = best * np.exp(0.2 * rng.standard_normal(11))
        excess = asked.largest(other).max() / wanted
        if excess <= 1:
            assert np.sum(weight / other) >= np.sum(weight / best) * (1 - 1e-6)


def test_what_no_cube_can_give_is_refused() -> None:
    unit = ToleranceUnit(PAPER.E, PAPER.D, np.full(3, 5e-6))
    asked = worst_case(lambda tilts: estimator_errors(tilts, unit).bias[2])
    with refused(AccuracyUnreachable, wanted=1e-6) as caught:
        allowed_tolerances(asked, 1e-6, P1_ITEMS, WEIGHT)
    assert 5e-6 < getattr(caught.value, "left") < 6e-6  # noqa: B009
    with refused(ValueError):
        allowed_tolerances(asked, 1e-5, np.zeros(11), WEIGHT)


def test_a_certificate_turning_the_imu_and_free_positions_buy_what_the_alias_says() -> None:
    cases = remedies(5e-6)
    plain, certified, once, twice, free, *_ = [remedy_gain(one, P1_ITEMS, PAPER, QUIET) for one in cases]
    assert plain.bias == pytest.approx(QUIET / 2, rel=2e-3)  # four dwells: docs/explanation/solving.md
    assert certified.bias == pytest.approx(QUIET / 2, rel=2e-3)  # parallelism is absorbed with or without
    spread = tilt_std(P1_ITEMS)
    pairs = spread[::2] ** 2 + spread[1::2] ** 2  # variance of p; K2 takes the common part of two cross sums
    alias = (
        np.sqrt([1 / (1 / pairs[[1, 2]]).sum(), 1 / (1 / pairs[[0, 2]]).sum(), 1 / (1 / pairs[[0, 1]]).sum()]) / 2
    )
    assert plain.bias_open == pytest.approx(alias.max(), rel=2e-2)
    assert certified.bias_open == pytest.approx(5e-6 / 2, rel=2e-2)
    assert once.bias_open > 20e-6  # a rotation has an axis: one combination is never seen
    assert twice.bias_open < 1e-7
    assert free.bias_open < 2e-7
    assert plain.misalignment > 10 * certified.misalignment
    assert certified.misalignment == pytest.approx(5e-6 / np.sqrt(2), rel=2e-2)
