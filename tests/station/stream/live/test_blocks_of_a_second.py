"""Seconds of a live feed: what is a block, where one begins anew, and what was missing."""

from collections.abc import Iterable

import numpy as np
import pytest

from drivers.simulated.line_faults import Fault
from station.stream.live.stillness import TICKS_PER_BLOCK, Block
from tests.station.stream.live.scripted_feed import BACK, GONE, Item, Script, chunks, device, feed_of


@pytest.mark.parametrize(
    ("format", "tells"), [("counts", True), ("stim300", False), ("kvh1750", False), ("ch70", False)]
)
def test_a_time_that_begins_again_as_it_runs_is_none(format: str, *, tells: bool) -> None:
    assert feed_of(Script(), format).tells_time is tells


@pytest.mark.parametrize(
    ("period", "size", "held"), [(0.02, 50, 10), (0.005, 200, 20), (0.5, TICKS_PER_BLOCK, 10)]
)
def test_a_second_is_a_block_once_a_tenth_of_a_second_more_has_come(period: float, size: int, held: int) -> None:
    script = Script([(0.0, [each]) for each in chunks(device(period), 2 * size + held)])
    feed, came = feed_of(script), list[tuple[int, int, int]]()
    feed.advance()
    feed.identify()
    assert feed.period == period
    while script.polls:
        came += [(feed.buffer.end, block.first, block.last) for block in feed.ready()]
        feed.advance()
    came += [(feed.buffer.end, block.first, block.last) for block in feed.ready()]
    assert came == [(size + held, 0, size), (2 * size + held, size, 2 * size)]


def blocks_of(items: Iterable[Item]) -> list[Block]:
    script = Script([(0.0, [each]) for each in items])
    feed, found = feed_of(script), list[Block]()
    feed.advance()
    feed.identify()
    while script.polls:
        feed.advance()
        found += feed.ready()
    return found


def test_a_block_begins_where_something_was_missing_and_says_so() -> None:
    found = blocks_of(chunks(device(faults=[Fault("lost", at_s=1.5, count=3)]), 260))
    assert [(block.is_broken, block.is_anew) for block in found] == [
        (True, True), (True, False), (False, False), (False, False),
    ]  # fmt: skip
    firsts = [block.first for block in found]
    assert firsts[0] == 0
    assert abs(firsts[1] - 75) <= 1  # the second begun before it is let go
    assert np.diff(firsts[1:]).tolist() == [50, 50]


def test_something_missing_in_the_moment_that_is_held_back_lets_the_second_before_it_go() -> None:
    found = blocks_of(chunks(device(faults=[Fault("lost", at_s=1.1, count=3)]), 200))
    assert found[0].first in range(53, 58)
    assert found[0].is_broken


def test_a_block_after_the_port_came_back_is_of_a_new_beginning() -> None:
    one = device()
    before, after = chunks(one, 130), chunks(one, 260)
    found = blocks_of([*before, GONE, BACK, *after])
    assert [(block.first, block.is_anew) for block in found] == [(0, True), (50, False), (130, True), (180, False)]


def test_what_was_let_go_is_in_no_block() -> None:
    script = Script([(0.0, chunks(device(), 300))])
    feed = feed_of(script)
    feed.advance()
    feed.identify()
    feed.buffer.forget_before(120)
    assert [block.first for block in feed.ready()] == [120, 170, 220]


def test_the_last_second_is_there_as_soon_as_it_is_whole_and_not_before_what_was_let_go() -> None:
    script = Script([(0.0, [each]) for each in chunks(device(), 60)])
    feed, there = feed_of(script), list[bool]()
    feed.advance()
    feed.identify()
    while script.polls:
        there.append(feed.newest() is not None)
        feed.advance()
    assert there.index(True) == 49
    feed.buffer.forget_before(10)
    assert feed.newest() is not None
    feed.buffer.forget_before(11)
    assert feed.newest() is None
