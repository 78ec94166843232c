import numpy as np
import pytest

from procedures.planning.campaign_design import CampaignDesign, HandTimes, Placement, usual_design
from procedures.planning.design_sigmas import with_all_solved
from procedures.planning.least_time import FEWEST, least_time, next_placement
from procedures.planning.order_search import OrderSearch
from tests.procedures.planning.bench_of_moves import accelerometer_bias, bench, gyroscopes, unit

ENGINE = bench(unit())
ASKED = with_all_solved(gyroscopes(bias=0.02), ENGINE.of(usual_design()))


@pytest.fixture(scope="module")
def planned() -> CampaignDesign:
    return least_time(ENGINE, ASKED, turns=False).design


def campaign() -> tuple[list[Placement], list[float]]:
    """Follow the rule to its end; return what was done and how much was said to be left each time."""
    done, left = list[Placement](), list[float]()
    while True:
        now = next_placement(ENGINE, ASKED, done)
        left.append(now.seconds)
        if now.placing is None:
            return done, left
        assert now.placing == now.way.placements[len(done)]  # what was done stands first in it
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
    head = [Placement(1, 30.0), Placement(3, 70.0)]
    asked = gyroscopes(k=3e-6, bias=0.02).and_also(accelerometer_bias(2e-7))
    found, score = OrderSearch(ENGINE, asked, 40.0, head=head).best(6, beginnings=2)
    assert found.placements[:2] == tuple(head)
    assert not {1, 3} & {at.position for at in found.placements[2:]}
    assert score == pytest.approx(float(asked.score(ENGINE.of(found))), rel=1e-4)


def test_what_cannot_be_reached_is_reported() -> None:
    done = [Placement(position, 50.0) for position in (1, 3, 6, 8)]
    found = next_placement(ENGINE, gyroscopes(bias=1e-4), done)
    assert not found.is_reachable
    assert found.placing is not None
    assert np.isfinite(found.seconds)
