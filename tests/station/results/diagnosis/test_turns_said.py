"""What turns say as a document: each by itself, and of several in both directions the mean."""

import pytest

from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from station.results.diagnosis.turns_said import turns, turns_lines
from tests.procedures.diagnosis.test_turns_seen import SCALE, recorded

SITE, CARE = Site(0.8, 9.80665, 0.02), ProcedureSigma(0.001, 2e-5)


def test_of_several_turns_the_mean_scale_factor_is_said_beside_each() -> None:
    both = (recorded(1, 720.0), recorded(2, 720.0, "-"))
    found = turns([Campaign("M", "S", False, SITE, (), both, CARE, Fixture())])
    assert len(found["turns"]) == 2
    [mean] = found["turns_mean"]
    assert mean["channel"] == "gyroscope z"
    assert mean["scale_factor"]["value"] == pytest.approx(SCALE, abs=4 * mean["scale_factor"]["std"])
    assert any(line.startswith("gyroscope z, all turns: 1.01") for line in turns_lines(found))


def test_without_a_turn_nothing_is_said() -> None:
    assert turns([Campaign("M", "S", False, SITE, (), (), CARE, Fixture())]) == {}
