"""How long a live feed waits: for a byte, a frame, a port that went, and what it looks at meanwhile."""

import pytest

from drivers.errors import LinkLost, LinkSilent, WrongFormat
from procedures.error_codes import ErrorCode
from station.stream.reader import Chunk
from tests.refusals import refused
from tests.station.stream.live.scripted_feed import BACK, GONE, NOISE, Script, chunks, device, feed_of


def test_a_line_without_a_byte_is_silent_after_so_long_and_no_sooner() -> None:
    feed = feed_of(Script([(1.0, []), (0.75, []), (0.1, [])]))
    for _ in range(2):
        feed.advance()
    with refused(LinkSilent, ErrorCode.DEVICE, "1.8 s", "115200 baud"):
        feed.advance()


def test_a_byte_begins_the_wait_for_bytes_anew_but_not_that_for_a_frame() -> None:
    feed = feed_of(Script([(1.0, []), (0.75, [Chunk(1, NOISE)]), (0.1, [Chunk(2, NOISE)])]))
    for _ in range(2):
        feed.advance()
    with refused(WrongFormat, ErrorCode.DEVICE, "115200 baud", bytes_seen=128):
        feed.advance()


def test_a_frame_begins_both_waits_anew() -> None:
    first, second = (each for each in chunks(device(), 2))
    feed = feed_of(Script([(1.75, []), (0.0, [first]), (1.75, []), (0.01, [second]), (1.75, []), (0.1, [])]))
    for _ in range(5):
        feed.advance()
    with pytest.raises(LinkSilent):
        feed.advance()


def test_a_port_that_went_may_stay_away_for_half_a_minute() -> None:
    feed = feed_of(Script([(1.7, []), (0.1, [GONE]), (20.0, []), (9.9, []), (0.2, [])]))
    for _ in range(4):
        feed.advance()
    assert (feed.lost, feed.losses) == ("unplugged", 1)
    assert "/dev/imu was lost (unplugged)" in feed.amiss
    with refused(LinkLost, ErrorCode.DEVICE, "unplugged", "30 s"):
        feed.advance()


def test_a_port_that_came_back_has_as_long_again_to_send() -> None:
    feed = feed_of(Script([(0.1, [GONE]), (10.0, []), (5.0, [BACK]), (1.7, []), (0.2, [])]))
    for _ in range(4):
        feed.advance()
    assert (feed.lost, feed.losses, feed.amiss) == ("", 1, "")
    with pytest.raises(LinkSilent):
        feed.advance()


def test_another_source_has_as_long_as_the_first_and_keeps_nothing_of_it() -> None:
    one = device()
    script = Script([(0.1, chunks(one, 40)), (1.7, [])])
    feed = feed_of(script)
    for _ in range(2):
        feed.advance()
    script.polls.extend([(1.7, []), (0.2, [])])
    feed.replace_source(script)
    assert (feed.buffer.begin, feed.buffer.first, feed.buffer.end) == (40, 40, 40)
    feed.advance()
    with pytest.raises(LinkSilent):
        feed.advance()
