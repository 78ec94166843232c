"""How long a live feed waits: for a byte, a frame, a port that went, and what it looks at meanwhile."""

from dataclasses import replace

import pytest

from drivers.errors import LinkLost, LinkSilent, WrongFormat
from station.stream.reader import Chunk
from tests.station.stream.live.scripted_feed import BACK, GONE, NOISE, TRIAD, Item, Script, chunks, device, feed_of


def test_a_line_without_a_byte_is_silent_after_so_long_and_no_sooner() -> None:
    feed = feed_of(Script([(1.0, []), (0.75, []), (0.1, [])]))
    for _ in range(2):
        feed.advance()
    with pytest.raises(LinkSilent, match=r"no bytes for 1\.8 s at 115200 baud"):
        feed.advance()


def test_a_byte_begins_the_wait_for_bytes_anew_but_not_that_for_a_frame() -> None:
    feed = feed_of(Script([(1.0, []), (0.75, [Chunk(1, NOISE)]), (0.1, [Chunk(2, NOISE)])]))
    for _ in range(2):
        feed.advance()
    with pytest.raises(WrongFormat, match=r"128 bytes at 115200 baud hold no counts frame"):
        feed.advance()


def test_a_frame_begins_both_waits_anew() -> None:
    first, second = (each for each in chunks(device(), 2))
    feed = feed_of(Script([(1.75, []), (0.0, [first]), (1.75, []), (0.01, [second]), (1.75, []), (0.1, [])]))
    for _ in range(5):
        feed.advance()
    with pytest.raises(LinkSilent):
        feed.advance()


def test_what_comes_instead_of_frames_is_looked_at_once_a_second() -> None:
    waits = [1.9, 0.5, 0.4, 0.2, 0.9]
    feed, said = feed_of(Script([(wait, [Chunk(1, NOISE)]) for wait in waits])), list[int]()
    for _ in waits:
        with pytest.raises(WrongFormat) as refused:
            feed.advance()
        said.append(refused.value.bytes_seen)
    assert said == [64, 64, 64, 4 * 64, 4 * 64]


def test_after_a_frame_what_comes_instead_is_looked_at_anew() -> None:
    (frame,) = chunks(device(), 1)
    noise: list[Item] = [Chunk(1, NOISE)]
    feed = feed_of(Script([(1.9, noise), (0.1, [frame]), (1.9, noise)]))
    with pytest.raises(WrongFormat) as first:
        feed.advance()
    feed.advance()
    with pytest.raises(WrongFormat) as second:
        feed.advance()
    assert second.value.bytes_seen > first.value.bytes_seen == 64


def test_of_what_comes_instead_the_newest_bytes_are_looked_at() -> None:
    noise, other = bytes(20_000), chunks(device(format="rawimus"), 400)
    feed = feed_of(Script([(0.5, [Chunk(1, noise)]), (1.9, other)]))
    feed.advance()
    with pytest.raises(WrongFormat, match="say format=rawimus") as refused:
        feed.advance()
    assert refused.value.bytes_seen == 16384


def test_what_must_join_samples_may_take_longer_for_its_first() -> None:
    waits = [3.0, 2.9, 0.2]
    feed = feed_of(Script([(wait, [Chunk(1, NOISE)]) for wait in waits], TRIAD), "triad")
    for _ in range(2):
        feed.advance()
    with pytest.raises(WrongFormat):
        feed.advance()


def test_a_port_that_went_may_stay_away_for_half_a_minute() -> None:
    feed = feed_of(Script([(1.7, []), (0.1, [GONE]), (20.0, []), (9.9, []), (0.2, [])]))
    for _ in range(4):
        feed.advance()
    assert (feed.lost, feed.losses) == ("unplugged", 1)
    assert feed.amiss == "/dev/imu was lost (unplugged); it is tried again and again: check cable and power"
    with pytest.raises(LinkLost, match=r"unplugged, not back within 30 s"):
        feed.advance()


def test_a_port_that_came_back_has_as_long_again_to_send() -> None:
    feed = feed_of(Script([(0.1, [GONE]), (10.0, []), (5.0, [BACK]), (1.7, []), (0.2, [])]))
    for _ in range(4):
        feed.advance()
    assert (feed.lost, feed.losses, feed.amiss) == ("", 1, "")
    with pytest.raises(LinkSilent):
        feed.advance()


def test_a_port_that_went_without_a_reason_is_gone_and_each_time_counts() -> None:
    feed = feed_of(Script([(0.1, [replace(GONE, reason="port lost: "), BACK, replace(GONE, reason="a reset")])]))
    feed.advance()
    assert (feed.lost, feed.losses) == ("a reset", 2)
    feed = feed_of(Script([(0.1, [replace(GONE, reason="port lost: ")])]))
    feed.advance()
    assert feed.lost == "gone"


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
