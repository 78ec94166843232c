"""One pose that is wrong is found where the others determine that it is; poses that all scatter name none."""

import numpy as np
import pytest

from procedures.anomalies.held_out_rows import WrongRow
from procedures.anomalies.wrong_poses import find_wrong_poses
from procedures.arrays import FloatArray
from procedures.inference import priors
from tests.procedures.free_positions.test_pose_means import BIAS, NOISE, SIX, directions, outputs

SEEDS = range(2)
WRONG = 3  # the row that is wrong


def lengthened(accel: FloatArray, row: int, sigmas: float) -> FloatArray:
    """Return means of which one is longer by so many sigmas of its noise."""
    found, force = accel.copy(), accel[row] - BIAS
    found[row] += sigmas * NOISE * force / np.linalg.norm(force)
    return found


def wrong_of(accel: FloatArray, *, stated: bool = True) -> tuple[WrongRow, ...]:
    std = np.full(accel.shape, NOISE if stated else 1e-6)
    return find_wrong_poses(accel, std, 1.0, is_std_stated=stated)


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("noise", [NOISE, 10 * NOISE])
@pytest.mark.parametrize("n", [10, 18])
def test_poses_that_scatter_alike_name_none(n: int, noise: float, stated: bool) -> None:
    for seed in SEEDS:
        assert not wrong_of(outputs(directions(n, seed), seed, noise), stated=stated)


@pytest.mark.parametrize(
    ("sigmas", "stated"), [(20, True), (300, True), (300, False), (-3000, True), (-3000, False)]
)
def test_a_pose_that_is_wrong_is_named_with_its_size(sigmas: float, stated: bool) -> None:
    for seed in SEEDS:
        (found,) = wrong_of(lengthened(outputs(directions(18, seed), seed), WRONG, sigmas), stated=stated)
        assert (found.row, found.alternatives) == (WRONG, ())
        assert found.probability > priors.ESTABLISHED
        u = abs(found.off) / found.sigmas
        assert abs(found.off - sigmas * NOISE) < 4 * u + 0.05 * abs(sigmas) * NOISE  # of the scale factor


def test_five_sigmas_name_no_pose_that_is_right() -> None:
    for seed in SEEDS:
        found = wrong_of(lengthened(outputs(directions(18, seed), seed), WRONG, 5))
        assert {each.row for each in found if each.probability > priors.LIKELY} <= {WRONG}


def test_two_wrong_poses_do_not_hide_each_other() -> None:
    for seed in SEEDS:
        accel = outputs(directions(18, seed), seed)
        found = wrong_of(lengthened(lengthened(accel, WRONG, 300), 11, 300))
        assert {each.row for each in found if each.probability > priors.ESTABLISHED} == {WRONG, 11}


def test_the_order_of_the_rows_has_no_influence() -> None:
    """The attitudes are unknown: two rows that are swapped are the same table."""
    accel = outputs(directions(18, 1), 1)
    accel[[2, 5]] = accel[[5, 2]]
    assert not wrong_of(accel)


def test_too_few_poses_name_none() -> None:
    """Nine poses and nine parameters: each is predicted from the others by nothing."""
    for accel in (outputs(SIX, 1), outputs(directions(9, 2), 2)):
        wrong = lengthened(accel, WRONG, 300)
        assert not wrong_of(wrong, stated=False)
        assert all(each.probability < priors.PRESENT for each in wrong_of(wrong))
