from dataclasses import replace

import numpy as np
import pytest

from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.wrong_positions import find_wrong_labels, label_findings, with_true_labels
from procedures.errors import WrongFace
from tests.procedures.diagnosis.planted import lively, planted


def recorded(seed: int, labels: dict[int, int], turns: bool = True) -> Campaign:
    """Return a campaign whose dwells in ``labels`` (recorded: actual) have one another's names."""
    campaign = planted(seed, dwell_s=8.0, turns=turns)
    stood = {dwell.position: dwell for dwell in campaign.dwells}
    dwells = [replace(stood[labels.get(p, p)], position=p, name=stood[p].name) for p in stood]
    return replace(campaign, dwells=tuple(dwells))


def found(campaign: Campaign) -> dict[int, int]:
    """Return the labels found wrong: recorded, actual."""
    return {campaign.dwells[each.dwell].position: each.position for each in find_wrong_labels([campaign])}


@pytest.mark.parametrize("seed", [4, 5])
def test_a_wrong_label_is_found_with_the_position_it_was(seed: int) -> None:
    rng = np.random.default_rng(seed)
    position = seed + 1
    for actual in rng.choice([p for p in range(1, 13) if p != position], 3, replace=False):
        effects = {"placement.label": {"position": float(position), "actual": float(actual)}}
        assert found(planted(seed, effects, dwell_s=6.0, turns=bool(seed % 2))) == {position: actual}


@pytest.mark.parametrize("labels", [{5: 9, 9: 5}, {1: 3, 6: 2, 9: 12}])
def test_several_wrong_labels_and_swapped_ones_are_found(labels: dict[int, int]) -> None:
    assert found(recorded(7, labels)) == labels


def test_the_half_turn_is_found_under_large_effects() -> None:
    for seed in range(2):
        position = seed + 1
        actual = position + 1 if position % 2 else position - 1
        label = {"placement.label": {"position": float(position), "actual": float(actual)}}
        assert found(planted(seed, lively(seed) | label, turns=True)) == {position: actual}


def test_right_labels_are_left_alone_whatever_else_is_wrong() -> None:
    for seed in range(4):
        assert found(planted(seed, lively(seed), dwell_s=8.0, turns=bool(seed % 2))) == {}


def test_without_gyroscopes_the_face_is_told_and_the_heading_left_open() -> None:
    campaign = planted(3, {"placement.label": {"position": 3.0, "actual": 9.0}})
    without = tuple(replace(d, series=replace(d.series, gyro=None)) for d in campaign.dwells)
    campaign = replace(campaign, dwells=without)
    findings, _ = label_findings([campaign], find_wrong_labels([campaign]))
    assert [dict(each.where) for each in findings] == [{"position": 3, "file": "dwell_03"}]
    assert findings[0].confidence == "likely"
    assert abs(findings[0].value[0] - 9) <= findings[0].std[0] == 1


def test_without_accelerometers_the_faces_are_taken_as_named_and_the_heading_is_told() -> None:
    campaign = recorded(7, {1: 2, 2: 1})
    without = tuple(replace(d, series=replace(d.series, accel=None)) for d in campaign.dwells)
    assert found(replace(campaign, dwells=without)) == {1: 2, 2: 1}


def test_solved_with_the_right_label_it_gives_the_truth() -> None:
    effects = {"placement.label": {"position": 3.0, "actual": 12.0}}
    campaign = planted(5, effects, turns=True)
    with pytest.raises(WrongFace):
        solve([campaign])
    corrected = with_true_labels([campaign], find_wrong_labels([campaign]))
    assert corrected[0].dwells[2].position == 12
    got, expected = solve(corrected).accelerometer, solve([planted(5, turns=True)]).accelerometer
    assert got is not None
    assert expected is not None
    assert np.all(np.abs(got.bias.value - expected.bias.value) < 4 * got.bias.std)
