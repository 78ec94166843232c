"""Plans of three or four placings: in the time given, what was done first, and no more where all is met."""

import numpy as np
import pytest

from procedures.planning import least_time as planning
from procedures.planning import order_search
from procedures.planning.campaign_design import HandTimes, of_positions, usual_design
from procedures.planning.design_sigmas import WantedSigmas, as_good_as, with_all_solved
from procedures.planning.least_time import (
    FEWEST,
    SHORTEST_S,
    equal_lengths,
    is_met,
    least_time,
    most_in_time,
    planned,
)
from tests.procedures.planning.bench_of_moves import accelerometer_bias, bench, gyroscopes, unit
from tests.refusals import refused

ENGINE = bench(unit())
HANDS = HandTimes()  # 45 s a placing, 61 s a turn
BIAS = gyroscopes(bias=0.02)
SHORTEST = 10.0  # s, of a dwell


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "FEWEST", 3)
    monkeypatch.setattr(planning, "MOST", 4)
    monkeypatch.setattr(planning, "SCANNED", 2)
    monkeypatch.setattr(order_search, "PLACEMENTS_OF_STARTS", 9)


def times(asked: WantedSigmas, factor: float) -> WantedSigmas:
    return WantedSigmas(asked.sigma * factor)


@pytest.mark.parametrize(("factor", "met"), [(1.0, True), (0.999, False), (1.001, True)])
def test_what_is_had_to_the_last_digit_is_met(factor: float, met: bool) -> None:
    design = of_positions((1, 3, 6, 8, 9), 40.0)
    sigmas = ENGINE.of(design)
    found = planned(ENGINE, times(as_good_as(sigmas), factor), design)
    assert found.is_met == met
    assert found.design is design
    assert found.sigmas == pytest.approx(sigmas)


@pytest.mark.usefixtures("few")
def test_less_than_the_shortest_campaign_is_refused_with_what_is_expected() -> None:
    with refused(ValueError, None, "2.8 min", "3 placements"):
        most_in_time(ENGINE, BIAS, 164.0 / 60)


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("turns", [True, False])
def test_the_shortest_campaign_meets_what_is_wanted_and_none_of_its_dwells_can_be_shorter(turns: bool) -> None:
    found = least_time(ENGINE, BIAS, turns=turns)
    assert found.is_met
    assert 3 <= len(found.design.positions) <= 4
    lengths = [at.seconds for at in found.design.placements if at.turn is None]
    for i, seconds in enumerate(lengths):
        if seconds > SHORTEST:
            shorter = [s - 5.0 * (j == i) for j, s in enumerate(lengths)]
            assert not is_met(ENGINE, BIAS, found.design.lasting(shorter))
    equal = equal_lengths(ENGINE, BIAS, found.design)
    assert equal is not None
    assert found.design.seconds(HANDS) <= equal.seconds(HANDS)


USUAL = ENGINE.of(usual_design())


@pytest.mark.parametrize(
    ("asked", "minutes"),
    [(gyroscopes(bias=0.02), 14.0), (accelerometer_bias(1e-6), 11.5)],
)
def test_what_is_wanted_is_met_in_the_minutes_of_the_page(asked, minutes: float) -> None:
    found = least_time(ENGINE, with_all_solved(asked, USUAL))
    assert found.is_met
    assert np.all(asked.ratios(found.sigmas) <= 1)
    assert found.design.minutes(HandTimes()) <= minutes
    assert np.all(np.isfinite(found.sigmas))


@pytest.mark.proof
def test_in_given_minutes_more_is_known_than_by_the_usual_campaign_cut_short() -> None:
    minutes = 20.0
    asked = as_good_as(USUAL)
    cut = ENGINE.of(usual_design(20.0))
    assert usual_design(20.0).minutes(HandTimes()) == pytest.approx(19.1, abs=0.1)
    found = most_in_time(ENGINE, asked, minutes)
    assert found.design.minutes(HandTimes()) <= minutes
    assert asked.worst(found.sigmas) < asked.worst(cut)
    assert min(at.seconds for at in found.design.placements) >= SHORTEST_S
    assert len(found.design.positions) >= FEWEST


def test_too_few_minutes_are_refused() -> None:
    with refused(ValueError, None, " min"):
        most_in_time(ENGINE, as_good_as(USUAL), 3.0)
