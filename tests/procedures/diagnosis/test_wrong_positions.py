"""Positions and rotations that were recorded under a wrong label are found and put right."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.anomalies.checks import check_campaigns
from procedures.anomalies.wrong_positions import (
    find_wrong_labels,
    label_findings,
    with_true_directions,
    with_true_labels,
)
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign
from procedures.errors import WrongFace
from tests.procedures.diagnosis.planted import lively, planted, with_reference_time


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


def test_without_gyroscopes_the_face_is_reported_and_the_heading_left_open() -> None:
    campaign = planted(3, {"placement.label": {"position": 3.0, "actual": 9.0}})
    without = tuple(replace(d, series=replace(d.series, gyro=None)) for d in campaign.dwells)
    campaign = replace(campaign, dwells=without)
    findings, _ = label_findings([campaign], find_wrong_labels([campaign]))
    assert [dict(each.where) for each in findings] == [{"position": 3, "file": "dwell_03"}]
    assert findings[0].confidence == "established"  # that the label is wrong; the sigma is that of the heading
    assert abs(findings[0].value[0] - 9) <= findings[0].std[0] == 1


def test_without_accelerometers_the_faces_are_taken_as_named_and_the_heading_is_reported() -> None:
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


# Rotations about one axis with exchanged labels


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return simulate_campaign(Truth.example(1), 1, dwell_s=30.0)


def relabelled(campaign: Campaign, axis: str) -> Campaign:
    other = {"+": "-", "-": "+"}
    return replace(campaign, turns=tuple(
        replace(turn, direction=other[turn.direction]) if turn.axis == axis else turn for turn in campaign.turns
    ))  # fmt: skip


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turns_with_the_wrong_label_are_turned_round_and_named(campaign: Campaign, axis: str) -> None:
    (corrected,), (finding,) = with_true_directions([relabelled(campaign, axis)])
    assert [turn.direction for turn in corrected.turns] == [turn.direction for turn in campaign.turns]
    assert finding.where == {"file": [turn.name for turn in campaign.turns if turn.axis == axis]}
    assert finding.confidence == "established"


def test_right_labels_are_left_alone(campaign: Campaign) -> None:
    (same,), findings = with_true_directions([campaign])
    assert same is campaign
    assert findings == ()


def test_a_label_a_shock_and_the_clock_are_put_right_together() -> None:
    effects = {
        "placement.label": {"position": 2.0, "actual": 9.0},
        "disturbance.dwell": {"x": 0.03, "y": 0.02, "position": 7.0, "at_s": 12.0, "duration_s": 4.0, "hz": 7.3},
        "clock.rate": {"value": -400.0},
    }
    campaign = with_reference_time(planted(8, effects, 30.0, turns=True), -400.0, 8)
    found = check_campaigns([campaign])
    assert [each.effect for each in found.findings] == ["placement.label", "disturbance.dwell", "clock.rate"]
    assert {each.confidence for each in found.findings} == {"established"}
    assert found.settled == {"placement.label", "disturbance.dwell", "clock.rate"}
    got, expected = (
        solve(found.campaigns).accelerometer,
        solve([planted(8, dwell_s=30.0, turns=True)]).accelerometer,
    )
    assert got is not None
    assert expected is not None
    for mine, true in ((got.bias, expected.bias), (got.scale_factor, expected.scale_factor)):
        assert np.all(np.abs(mine.value - true.value) < 4 * np.hypot(mine.std, true.std))


def test_a_clean_campaign_is_left_as_it_is() -> None:
    campaign = planted(9, turns=True)
    found = check_campaigns([campaign])
    assert found.findings == ()
    assert found.campaigns[0].dwells == campaign.dwells
    assert "clock.rate" not in found.settled
