import numpy as np
import pytest

from procedures.planning.campaign_design import HandTimes, usual_design
from procedures.planning.dwell_lengths import SHORTEST_S
from procedures.planning.least_time import FEWEST, LONGEST_MIN, least_time, most_in_time
from procedures.planning.wanted_sigmas import as_good_as, with_all_solved
from tests.procedures.planning.bench_of_moves import accelerometer_bias, bench, gyroscopes, unit
from tests.refusals import refused

ENGINE = bench(unit())
USUAL = ENGINE.of(usual_design())


@pytest.mark.parametrize(
    ("asked", "minutes"),
    [(gyroscopes(bias=0.02), 14.0), (accelerometer_bias(1e-7), 20.0), (accelerometer_bias(1e-6), 11.5)],
)
def test_what_is_wanted_is_met_in_the_minutes_of_the_page(asked, minutes: float) -> None:
    found = least_time(ENGINE, with_all_solved(asked, USUAL))
    assert found.is_met
    assert np.all(asked.ratios(found.sigmas) <= 1)
    assert found.design.minutes(HandTimes()) <= minutes
    assert np.all(np.isfinite(found.sigmas))


def test_what_cannot_be_met_is_met_as_well_as_an_hour_allows() -> None:
    asked = gyroscopes(bias=0.001)
    found = least_time(ENGINE, asked, turns=False)
    assert not found.is_met
    assert found.design.minutes(HandTimes()) <= LONGEST_MIN
    assert asked.worst(found.sigmas) < asked.worst(USUAL)


def test_in_given_minutes_more_is_known_than_by_the_usual_campaign_cut_short() -> None:
    minutes = 20.0
    asked = as_good_as(USUAL)
    cut = ENGINE.of(usual_design(20.0))
    assert usual_design(20.0).minutes(HandTimes()) == pytest.approx(19.1, abs=0.1)
    found = most_in_time(ENGINE, asked, minutes)
    assert found.design.minutes(HandTimes()) <= minutes
    assert asked.worst(found.sigmas) < asked.worst(cut)
    assert min(at.seconds for at in found.design.placings) >= SHORTEST_S
    assert len(found.design.positions) >= FEWEST


def test_too_few_minutes_are_refused() -> None:
    with refused(ValueError, None, " min"):
        most_in_time(ENGINE, as_good_as(USUAL), 3.0)
