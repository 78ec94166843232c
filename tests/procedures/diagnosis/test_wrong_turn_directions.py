"""Turns about one axis whose labels are exchanged: told by the Earth's rate in the dwells, and turned round."""

from dataclasses import replace

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.wrong_turn_directions import with_true_directions


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
