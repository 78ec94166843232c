"""The last second of a stream, for a look in between: whole or none, and no block of its own."""

from drivers.simulated.line_faults import Fault
from station.stream.live.live_feed import LiveFeed
from tests.station.stream.live.line_in_memory import PERIOD, LineInMemory

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
