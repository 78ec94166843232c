"""A hand turn of blocks whose rates are written down: what it adds up to, and why it was not the one asked for."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.plan_steps import Turn
from station.stream.live.rotation_detection import RotationDetector
from station.stream.live.stillness import Block

REST = np.array([3.0, -2.0, 1.0])  # counts/s
C_SB = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # cube z is sensor x
STEP = Turn("z", "+", 2, 1, rest_s=2.0)
PERIOD = 0.01  # s; a block is 100 samples


def block(number: int, *rate: float, last: int | None = None, broken: bool = False) -> Block:
    turned = np.array(rate or (0.0, 0.0, 0.0))
    return Block(
        100 * number, last or 100 * number + 100, np.concatenate((REST + turned, np.zeros(3))), np.full(6, 0.4),
        float(number), number + 1.0, 25.0, is_healthy=True, is_broken=broken, is_restarted=False,
    )  # fmt: skip


def watch(step: Turn = STEP, earlier: tuple[float, ...] = ()) -> RotationDetector:
    made = RotationDetector(step, C_SB, PERIOD, earlier)
    for number in range(3):
        made.rest(block(number))
    return made


def turned(made: RotationDetector, *rates: tuple[float, ...], first: int = 3) -> RotationDetector:
    """Move at the rates, a block each, and rest again."""
    for number, rate in enumerate(rates, first):
        made.take(block(number, *rate), is_still=False)
    for number in (0, 1):
        made.take(block(first + len(rates) + number), is_still=True)
    return made


def test_a_turn_is_the_counts_of_the_axis_less_its_rate_at_rest() -> None:
    made = watch()
    assert not made.is_moving
    assert made.turned_counts == made.count_rate == made.moved_s == 0.0
    made.take(block(3, 500.0, 4.0, 0.0), is_still=False)
    assert made.is_moving
    assert made.count_rate == pytest.approx(500.0)
    made.take(block(4, 300.0, -4.0, 0.0, last=550), is_still=False)  # half a second more
    assert made.turned_counts == pytest.approx(500.0 + 1.5 * 300.0)
    assert made.counts_per_revolution == pytest.approx(475.0)
    assert made.moved_s == pytest.approx(2.5)
    assert made.rested_s == 0.0
    assert made.is_about_axis
    made.take(block(6), is_still=True)
    assert (made.is_over, made.count_rate) == (False, 0.0)
    made.take(block(7), is_still=True)
    assert made.is_over
    assert made.rested_s == pytest.approx(2.0)
    assert made.rest_rate == pytest.approx(REST)


def test_a_rest_with_a_gap_in_it_restarts() -> None:
    for bad in (block(4), block(3, broken=True)):
        made = watch()
        made.rest(bad)
        assert [each.first for each in made.rests[0]] == [bad.first]


def test_a_pause_is_part_of_the_turn_and_what_follows_the_rest_is_not() -> None:
    made = watch()
    for number, (rate, is_still) in enumerate(
        [(500.0, False), (0.0, True), (500.0, False), *[(0.0, True)] * 3], 3
    ):
        made.take(block(number, rate, 0.0, 0.0), is_still=is_still)
    assert [each.first for each in made.step_blocks()] == [100, 200, 300, 400, 500, 600, 700]
    assert made.turned_counts == pytest.approx(1000.0)
    assert [each.first for each in made.rests[1]] == [600, 700]
    assert made.fault() == ""


@pytest.mark.parametrize(("across", "is_about"), [(190.0, True), (210.0, False), (-210.0, False)])
def test_a_fifth_of_the_turn_may_show_on_another_axis(across: float, is_about: bool) -> None:
    for rate in ((1000.0, across, 0.0), (-1000.0, 0.0, across)):
        made = turned(watch(), rate)
        assert made.is_about_axis == is_about
        assert ("tipped" in made.fault()) == (not is_about)


@pytest.mark.parametrize(
    ("direction", "rate", "reported"),
    [
        ("+", 500.0, ""),
        ("-", -500.0, ""),
        ("+", -500.0, "expected counter-clockwise"),
        ("-", 500.0, "expected clockwise"),
    ],
)
def test_the_direction_is_the_sign_about_the_axis(direction: str, rate: float, reported: str) -> None:
    made = turned(watch(), (rate, 0.0, 0.0))
    made.take_as(replace(STEP, direction=direction))
    assert made.fault() == reported or (reported and reported in made.fault())


@pytest.mark.parametrize(
    ("total", "reported"),
    [
        (2150.0, ""),
        (1850.0, ""),
        (2250.0, "it was 2.25 revolutions"),
        (1750.0, "it was 1.75 revolutions, by the turns"),
    ],
)
def test_one_revolution_more_or_less_is_seen_by_the_turns_before(total: float, reported: str) -> None:
    made = turned(watch(earlier=(1000.0, 900.0, 2000.0)), (total, 0.0, 0.0))  # the median
    assert reported in made.fault()
    assert bool(reported) == bool(made.fault())


def test_lost_samples_and_no_rest_are_reported() -> None:
    assert turned(watch(), (500.0, 0.0, 0.0), first=4).fault() == "samples were lost while it turned"
    made = watch()
    made.take(block(3, 500.0, broken=True), is_still=False)
    assert "lost" in turned(made, (500.0, 0.0, 0.0), first=4).fault()
    one = RotationDetector(STEP, C_SB, PERIOD, ())
    one.rest(block(2))
    assert turned(one, (500.0, 0.0, 0.0)).fault() == "there was no rest before it"
