"""Dwells on another face than their position names, and IMUs mounted otherwise than said: named, never guessed."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.face_check import refuse_wrong_faces
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Fixture
from procedures.errors import WrongFace, WrongMounting
from procedures.frames import face_of
from tests.procedures.calibration.simulated_campaigns import fine, scores, simulated, usual
from tests.procedures.independent import body_from_level, dwells
from tests.refusals import refused


def nominal_rates(positions: list[int], C_sb: FloatArray) -> FloatArray:
    """Raw outputs of a misaligned, biased unit in these positions."""
    E = np.eye(3) + 5e-3 * np.random.default_rng(1).standard_normal((3, 3))
    u = np.array([C_sb @ body_from_level(p)[:, 2] for p in positions])
    return np.array([1000.0, 990.0, 1010.0]) * (u @ E.T + [2e-3, -1e-3, 3e-3])


@pytest.mark.parametrize("wrong", [pytest.param(p * (p in {5, 6, 7, 8})) for p in range(1, 13)])
def test_one_wrong_label_is_named_with_both_faces(wrong: int) -> None:
    rate = nominal_rates(list(range(1, 13)), np.eye(3))
    for named in range(1, 13):
        if face_of(named) == face_of(wrong):
            continue
        labels = list(range(1, 13))
        labels[wrong - 1] = named
        with pytest.raises(WrongFace) as caught:
            refuse_wrong_faces(dwells(rate, 1e-3, labels), [np.eye(3)])
        assert (caught.value.position, caught.value.named, caught.value.seen) == (
            named,
            face_of(named),
            face_of(wrong),
        )
        assert caught.value.step == f"dwell_{named:02d}"


@pytest.mark.parametrize("output_per_g", [1e-4, 1.0])
def test_a_wrong_label_is_named_whatever_the_unit_of_the_output(output_per_g: float) -> None:
    rate = output_per_g / 1000.0 * nominal_rates(list(range(1, 13)), np.eye(3))
    with pytest.raises(WrongFace):
        refuse_wrong_faces(dwells(rate, 1e-6 * output_per_g, [5, *range(2, 13)]), [np.eye(3)])


def test_outputs_that_never_change_contradict_no_label() -> None:
    refuse_wrong_faces(dwells(np.ones((12, 3)), 1e-3, list(range(1, 13))), [np.eye(3)])


def test_a_wrong_label_is_refused_by_solve_and_named_by_its_file() -> None:
    _, campaign = usual()
    steps = list(campaign.dwells)
    steps[3] = replace(steps[3], position=5)
    with refused(WrongFace, step="dwell_04", position=5, named="y_up", seen="x_down"):
        solve([replace(campaign, dwells=tuple(steps))])


@pytest.mark.parametrize(
    "positions",
    [
        [1, 3, 5, 9],
        [1, 3],
        [1],
        [1, 2, 3, 4],
        [1, 3, 5, 7, 9, 11],
        [2, 6, 10, 12],
        list(range(1, 12)),
        [1, 1, 1, 5],
    ],
)
@pytest.mark.parametrize("C_sb", [np.eye(3), np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])])
def test_correct_labels_are_never_refused(positions: list[int], C_sb: FloatArray) -> None:
    refuse_wrong_faces(dwells(nominal_rates(positions, C_sb), 1e-3, positions), [C_sb])


@pytest.mark.parametrize(
    "axes",
    [
        ("+y", "-x", "+z"),
        pytest.param(("-x", "-y", "+z")),
        ("+z", "+x", "+y"),
        ("-y", "+z", "-x"),
    ],
)
def test_a_wrong_mounting_is_named(axes: tuple[str, str, str]) -> None:
    truth = replace(fine(9), imu_axes=axes)
    campaign = simulated(truth, 9, turns=())
    with refused(WrongMounting, seen=str(list(axes))):
        solve([replace(campaign, fixture=Fixture())])
    assert np.abs(scores(solve([campaign]), truth)).max() < 4
