import itertools
from collections.abc import Sequence

import numpy as np
import pytest

from procedures.planning.campaign_design import ROTATION_PLACEMENTS, CampaignDesign, Placement, of_positions
from procedures.planning.order_search import OrderSearch, flips
from procedures.positions import POSITIONS
from tests.procedures.planning.bench_of_moves import ARCSEC, accelerometer_bias, bench, gyroscopes, unit


def test_the_search_is_within_5_percent_of_every_order_there_is() -> None:
    engine, among, seconds = bench(unit()), range(1, len(POSITIONS) + 1), 50.0
    asked = gyroscopes(k=5e-6, bias=0.02)
    can = flips()
    every = [
        order for order in itertools.permutations(among, 4)
        if all(can[a - 1, b - 1] for a, b in itertools.pairwise(order))
    ]  # fmt: skip
    assert len(every) > 1000
    least = min(float(asked.score(engine.of(of_positions(order, seconds)))) for order in every)
    found, score = OrderSearch(engine, asked, seconds, among).best(4)
    assert np.isfinite(score)
    assert score <= 1.05 * least
    assert score == pytest.approx(float(asked.score(engine.of(found))), rel=1e-3)


def test_an_order_has_a_scale_factor_of_2_2_ppm_and_a_misalignment_of_1_8_arcsec() -> None:
    engine, asked = bench(unit()), gyroscopes(k=2.2e-6, misalignment=1.8 * ARCSEC)
    found, _ = OrderSearch(engine, asked, 100.0).best(12)
    assert asked.worst(engine.of(found)) < 1
    assert len(set(found.positions)) == 12
    steps = [flips()[a - 1, b - 1] for a, b in itertools.pairwise(found.positions)]
    assert all(steps)


def test_the_scores_of_exchanges_are_those_of_whole_designs_with_turns_after_them() -> None:
    engine, asked = bench(unit()), gyroscopes(k=2e-6, misalignment=ARCSEC, bias=0.01)
    found, score = OrderSearch(engine, asked, 60.0, tail=ROTATION_PLACEMENTS).best(6, beginnings=2)
    assert found.placements[6:] == ROTATION_PLACEMENTS
    assert score == pytest.approx(float(asked.score(engine.of(found))), rel=1e-5)


# Orders so short that every one can be tried


ENGINE = bench(unit())
ASKED = gyroscopes(k=3e-6, misalignment=ARCSEC, bias=0.02).and_also(accelerometer_bias(2e-7))
AMONG = (1, 3, 4, 6, 8, 9)
SECONDS = 40.0
CAN = flips()


def designs(n: int, head: Sequence[Placement] = (), tail: Sequence[Placement] = ()) -> list[CampaignDesign]:
    """Return every order of ``n`` dwells that goes by flips, between what stands before and after."""
    before = tuple(at.position for at in head[-1:])
    done = {at.position for at in head}
    orders = [
        order for order in itertools.permutations([p for p in AMONG if p not in done], n)
        if all(CAN[a - 1, b - 1] for a, b in itertools.pairwise((*before, *order)))
    ]  # fmt: skip
    assert len(orders) > 5
    return [CampaignDesign((*head, *(Placement(p, SECONDS) for p in order), *tail)) for order in orders]


def score(design: CampaignDesign) -> float:
    return float(ASKED.score(ENGINE.of(design)))


ENDS = {
    "nothing": ((), ()),
    "dwells before": ((Placement(2, 30.0), Placement(1, 70.0)), ()),
    "a turn before": ((Placement(2, 30.0), ROTATION_PLACEMENTS[0]), ()),
    "turns after": ((), ROTATION_PLACEMENTS),
    "two turns after": ((), (ROTATION_PLACEMENTS[4], ROTATION_PLACEMENTS[1])),
    "both": ((Placement(12, 55.0),), ROTATION_PLACEMENTS[2:4]),
}


@pytest.mark.parametrize("ends", ENDS)
def test_the_best_of_all_orders_is_found_with_its_score(ends: str) -> None:
    head, tail = ENDS[ends]
    found, reported = OrderSearch(ENGINE, ASKED, SECONDS, AMONG, tail, head).best(3, beginnings=25)
    every = designs(3, head, tail)
    assert found in every
    assert score(found) == pytest.approx(min(map(score, every)), rel=1e-5)
    assert reported == pytest.approx(score(found), rel=1e-6)
