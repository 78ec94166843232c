"""Seconds of a live feed: what is a block, where one begins again, what was missing, and the newest one."""

from collections.abc import Iterable

import numpy as np
import pytest

from drivers.simulated.line_faults import Fault
from station.stream.live.live_feed import LiveFeed
from station.stream.live.stillness import TICKS_PER_BLOCK, Block
from tests.station.stream.live.line_in_memory import PERIOD, LineInMemory
from tests.station.stream.live.scripted_feed import BACK, GONE, Item, Script, chunks, device, feed_of


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


def test_a_block_after_the_port_came_back_is_of_a_new_beginning() -> None:
    one = device()
    before, after = chunks(one, 130), chunks(one, 260)
    found = blocks_of([*before, GONE, BACK, *after])
    assert [(block.first, block.is_anew) for block in found] == [(0, True), (50, False), (130, True), (180, False)]


LOST_S = 6.0


def test_it_is_whole_or_none_and_says_nothing_of_what_was_before() -> None:
    line = LineInMemory("counts", [Fault("lost", at_s=LOST_S, count=3)])
    feed, looked = LiveFeed(line, line.wire, clock=line.clock), list[tuple[float, bool]]()
    while line.clock() < 12.0:
        feed.advance()
        if feed.unit is None and feed.buffer.end > 100:
            feed.identify("SIM", None if feed.stream.decoder.serial else "7")
        for block in feed.ready() if feed.unit else ():
            assert block.last - block.first == round(1 / PERIOD)
        if feed.unit is None:
            continue
        newest = feed.newest()
        looked.append((feed.buffer.end * PERIOD, newest is not None))
        if newest is not None:
            assert (newest.first, newest.last) == (feed.buffer.end - round(1 / PERIOD), feed.buffer.end)
            assert not newest.is_broken
            assert not newest.is_anew
    missing = [at for at, is_whole in looked if not is_whole and at > 2.0]
    assert missing  # while what is lost lies in the last second
    assert LOST_S - 0.3 < missing[0]
    assert missing[-1] < LOST_S + 1.3
    assert looked[-1][1]
