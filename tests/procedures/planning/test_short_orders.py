"""Orders so short that every one can be tried: the search finds the best, keeps its ends and scores the whole."""

import itertools
from collections.abc import Sequence

import numpy as np
import pytest

from procedures.frames import ATTITUDES
from procedures.planning.campaign_design import TURN_PLACINGS, CampaignDesign, Placing, of_positions
from procedures.planning.order_search import OrderSearch, flips
from procedures.planning.wanted_sigmas import WantedSigmas
from tests.procedures.planning.bench_of_moves import ARCSEC, accelerometer_bias, bench, gyroscopes, unit

ENGINE = bench(unit())
ASKED = gyroscopes(k=3e-6, misalignment=ARCSEC, bias=0.02).and_also(accelerometer_bias(2e-7))
AMONG = (1, 3, 4, 6, 8, 9)
SECONDS = 40.0
CAN = flips()
THIRD = (ATTITUDES.index("UEN") + 1, ATTITUDES.index("ENU") + 1)  # a third of a turn from each other


def designs(
    n: int, head: Sequence[Placing] = (), tail: Sequence[Placing] = (), moves: bool = True
) -> list[CampaignDesign]:
    """Return every order of ``n`` dwells that goes by flips, between what stands before and after."""
    before = tuple(at.position for at in head[-1:])
    done = {at.position for at in head}
    orders = [
        order for order in itertools.permutations([p for p in AMONG if p not in done], n)
        if all(CAN[a - 1, b - 1] for a, b in itertools.pairwise((*before, *order)))
    ]  # fmt: skip
    assert len(orders) > 5
    return [CampaignDesign((*head, *(Placing(p, SECONDS) for p in order), *tail), moves) for order in orders]


def score(design: CampaignDesign, asked: WantedSigmas = ASKED) -> float:
    return float(asked.score(ENGINE.of(design)))


ENDS = {
    "nothing": ((), ()),
    "dwells before": ((Placing(2, 30.0), Placing(1, 70.0)), ()),
    "a turn before": ((Placing(2, 30.0), TURN_PLACINGS[0]), ()),
    "turns after": ((), TURN_PLACINGS),
    "two turns after": ((), (TURN_PLACINGS[4], TURN_PLACINGS[1])),
    "both": ((Placing(12, 55.0),), TURN_PLACINGS[2:4]),
}


@pytest.mark.parametrize("moves", [True, False])
@pytest.mark.parametrize("ends", ENDS)
def test_the_best_of_all_orders_is_found_with_its_score(ends: str, moves: bool) -> None:
    head, tail = ENDS[ends]
    asked = ASKED if moves or tail else accelerometer_bias(2e-7)  # without a rotation scale factors are open
    search = OrderSearch(ENGINE, asked, SECONDS, AMONG, tail, moves, head)
    found, said = search.best(3, beginnings=25)
    every = designs(3, head, tail, moves)
    least = min(score(each, asked) for each in every)
    assert found.placings in [each.placings for each in every]
    assert found.moves == moves
    assert score(found, asked) == pytest.approx(least, rel=1e-5)
    assert said == pytest.approx(score(found, asked), rel=1e-6)


@pytest.mark.parametrize("moves", [True, False])
@pytest.mark.parametrize("ends", ENDS)
def test_what_is_improved_gains_by_no_other_dwell_in_any_place(ends: str, moves: bool) -> None:
    head, tail = ENDS[ends]
    asked = ASKED if moves or tail else accelerometer_bias(2e-7)
    every = designs(3, head, tail, moves)
    begun = max(every, key=lambda each: score(each, asked))
    search = OrderSearch(ENGINE, asked, SECONDS, AMONG, tail, moves, head)
    inner = CampaignDesign(begun.placings[len(head) : len(head) + 3])
    found, said = search.improved(inner)
    assert said == pytest.approx(score(found, asked), rel=1e-6)
    assert said < score(begun, asked)
    one_off = [
        each for each in every
        if sum(a != b for a, b in zip(each.positions, found.positions, strict=True)) == 1
    ]  # fmt: skip
    assert all(score(each, asked) >= said * (1 - 2e-6) for each in one_off)
    again, same = search.improved(CampaignDesign(found.placings[len(head) : len(head) + 3]))
    assert (again.placings, same) == (found.placings, pytest.approx(said, rel=1e-7))


def test_the_dwells_last_as_long_as_was_said_and_what_was_done_as_it_did() -> None:
    head = (Placing(2, 30.0), Placing(1, 70.0))
    found, _ = OrderSearch(ENGINE, ASKED, 25.0, AMONG, TURN_PLACINGS, head=head).best(2, beginnings=1)
    assert [at.seconds for at in found.placings] == [30.0, 70.0, 25.0, 25.0, *[0.0] * 6]


def test_a_seed_gives_the_same_order_again() -> None:
    search = OrderSearch(ENGINE, ASKED, SECONDS)
    first, _ = search.best(5, 3, 1)
    assert search.best(5, 3, 1)[0].placings == first.placings
    assert any(search.best(5, seed, 1)[0].placings != first.placings for seed in range(4, 8))


@pytest.mark.parametrize(("among", "n", "length"), [((1,), 1, 1), ((1,), 3, 1), (AMONG, 9, 6), (THIRD, 2, 1)])
def test_fewer_dwells_come_where_no_walk_has_so_many(among: Sequence[int], n: int, length: int) -> None:
    found, said = OrderSearch(ENGINE, ASKED, SECONDS, among).best(n, beginnings=1)
    assert len(found.positions) == length
    assert set(found.positions) <= set(among)
    assert said == pytest.approx(score(found), rel=1e-6)


@pytest.mark.parametrize(
    ("head", "among", "can"),
    [
        ((), (1,), True), ((1,), (1,), False), ((1,), (1, 2), True), ((THIRD[0],), (THIRD[1],), False),
        ((1, THIRD[0]), (THIRD[1],), False), ((THIRD[0], THIRD[1]), THIRD, False),
    ],
)  # fmt: skip
def test_it_goes_on_where_an_attitude_is_left_that_a_flip_leads_to(
    head: Sequence[int], among: Sequence[int], can: bool
) -> None:
    before = of_positions(head, SECONDS).placings
    assert OrderSearch(ENGINE, ASKED, SECONDS, among, head=before).can_go_on() == can


def test_a_flip_is_a_quarter_or_half_a_turn_about_one_axis() -> None:
    of = {name: i for i, name in enumerate(ATTITUDES)}
    first = "UEN"
    assert not CAN[of[first], of[first]]
    assert CAN[of[first], of["DWN"]]  # half a turn about north
    assert CAN[of[first], of["USE"]] or CAN[of[first], of["UNW"]]  # a quarter about up
    assert not CAN[of["UEN"], of["ENU"]]
    assert CAN.dtype == np.bool_
