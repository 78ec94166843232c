import numpy as np
import pytest

from procedures.planning.campaign_design import CampaignDesign, HandTimes, Placing, usual_design
from procedures.planning.least_time import FEWEST, least_time
from procedures.planning.order_search import OrderSearch
from procedures.planning.sequential import next_placing
from procedures.planning.wanted_sigmas import with_all_solved
from tests.procedures.planning.bench_of_moves import accelerometer_bias, bench, gyroscopes, unit

ENGINE = bench(unit())
ASKED = with_all_solved(gyroscopes(bias=0.02), ENGINE.of(usual_design()))


@pytest.fixture(scope="module")
def planned() -> CampaignDesign:
    return least_time(ENGINE, ASKED, turns=False).design


def campaign() -> tuple[list[Placing], list[float]]:
    """Follow the rule to its end; return what was done and how much was said to be left each time."""
    done, left = list[Placing](), list[float]()
    while True:
        now = next_placing(ENGINE, ASKED, done)
        left.append(now.seconds)
        if now.placing is None:
            return done, left
        assert now.placing == now.way.placings[len(done)]  # what was done stands first in it
        done.append(now.placing)
        assert len(done) < 20


@pytest.mark.proof
def test_step_by_step_it_takes_hardly_longer_than_the_plan_and_stops_when_all_is_met(
    planned: CampaignDesign,
) -> None:
    done, left = campaign()
    design = CampaignDesign(tuple(done))
    assert ASKED.worst(ENGINE.of(design)) <= 1
    assert design.minutes(HandTimes()) <= 1.1 * planned.minutes(HandTimes())
    assert left == sorted(left, reverse=True)
    assert len({at.position for at in done}) == len(done) >= FEWEST


def test_what_was_done_stays_and_its_score_is_that_of_the_whole() -> None:
    head = [Placing(1, 30.0), Placing(3, 70.0)]
    asked = gyroscopes(k=3e-6, bias=0.02).and_also(accelerometer_bias(2e-7))
    found, score = OrderSearch(ENGINE, asked, 40.0, head=head).best(6, beginnings=2)
    assert found.placings[:2] == tuple(head)
    assert not {1, 3} & {at.position for at in found.placings[2:]}
    assert score == pytest.approx(float(asked.score(ENGINE.of(found))), rel=1e-4)


def test_what_cannot_be_reached_is_said() -> None:
    done = [Placing(position, 50.0) for position in (1, 3, 6, 8)]
    found = next_placing(ENGINE, gyroscopes(bias=1e-4), done)
    assert not found.is_reachable
    assert found.placing is not None
    assert np.isfinite(found.seconds)
