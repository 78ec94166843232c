"""A live feed in memory: sources, pulses, a format that is found, seconds, and how long it waits."""

import time
from collections.abc import Iterable

import numpy as np
import pytest

from drivers.errors import BadDeviceUrl, LinkLost, LinkSilent, ReplayEnded, WrongFormat
from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.live.stillness import TICKS_PER_BLOCK, Block
from station.stream.reader import Chunk
from tests.refusals import refused
from tests.station.stream.live.bench_in_memory import Source
from tests.station.stream.live.line_in_memory import PERIOD, LineInMemory
from tests.station.stream.live.scripted_feed import BACK, GONE, NOISE, Item, Script, chunks, device, feed_of


def test_a_pulse_is_handed_over_once_with_the_device_time_at_which_it_came() -> None:
    feed = LiveFeed(source := Source(Truth(sample_period_s=0.01), format="rawimus", pps=True), FORMATS["rawimus"])
    while source.device.imu.time < 3.2:
        feed.advance()
    assert feed.stamp is not None
    assert feed.pulse_age is not None
    host_ns, at = feed.stamp
    assert host_ns == round(source.device.imu.time * 1e9)
    newest = at - feed.pulse_age
    found = feed.pulses(newest - 0.5)
    assert sorted({round(each - newest, 3) for each in found}) == [-3.0, -2.0, -1.0]
    assert not feed.pulses(newest - 0.5)
    left = feed.pulses(newest + 1e-9)
    assert left
    assert left == pytest.approx([newest] * len(left))
    assert not feed.pulses(1e9)


@pytest.mark.parametrize(
    ("url", "option"),
    [("mavlink:udpin:127.0.0.1:1455", "--gnss"), ("camera:http://127.0.0.1:50/x", "--camera")],
)
def test_the_address_of_something_else_is_refused_with_the_option_that_takes_it(url: str, option: str) -> None:
    with refused(BadDeviceUrl, ErrorCode.DEVICE_ADDRESS, option):
        open_feed(Script(url=url))


SNIFFED = "serial:///dev/imu"


def test_a_format_is_found_by_three_frames_and_these_are_the_first_samples() -> None:
    script = Script([(0.0, [each]) for each in chunks(device(format="rawimus"), 5)], SNIFFED)
    feed = open_feed(script)
    assert feed.wire.name == "rawimus"
    assert (feed.buffer.end, len(script.polls)) == (3, 2)
    assert [len(piece.block) for piece, _ in zip(feed.pieces(), range(3), strict=False)] == [1, 1, 1]


@pytest.mark.parametrize(
    ("items", "error", "reported"),
    [
        ([], LinkSilent, "1.8 s"),
        ([Chunk(1, NOISE), GONE, Chunk(2, NOISE)], WrongFormat, "128 bytes at 921600 baud"),
    ],
)
def test_a_format_that_is_not_found_in_time_is_refused(
    items: list[Item], error: type[Exception], reported: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = Script([(0.0, [each]) for each in items], SNIFFED)
    monkeypatch.setattr(time, "monotonic", script.clock)
    with refused(error, ErrorCode.DEVICE, reported):
        open_feed(script)
    assert 1.8 <= script.now < 1.95


def test_a_recording_that_ends_before_its_format_is_found_is_refused() -> None:
    class Ended(Script):
        def poll(self, timeout_s: float) -> list[Item]:
            raise ReplayEnded("a.mcap", 7)

    with refused(DataRefused, None, "7 bytes"):
        open_feed(Ended(url=SNIFFED))


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
    assert [(block.is_broken, block.is_restarted) for block in found] == [
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
    assert [(block.first, block.is_restarted) for block in found] == [
        (0, True),
        (50, False),
        (130, True),
        (180, False),
    ]


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
            assert not newest.is_restarted
    missing = [at for at, is_whole in looked if not is_whole and at > 2.0]
    assert missing  # while what is lost lies in the last second
    assert LOST_S - 0.3 < missing[0]
    assert missing[-1] < LOST_S + 1.3
    assert looked[-1][1]


def test_a_line_without_a_byte_is_silent_after_so_long_and_no_sooner() -> None:
    feed = feed_of(Script([(1.0, []), (0.75, []), (0.1, [])]))
    for _ in range(2):
        feed.advance()
    with refused(LinkSilent, ErrorCode.DEVICE, "1.8 s", "115200 baud"):
        feed.advance()


def test_a_byte_restarts_the_wait_for_bytes_but_not_that_for_a_frame() -> None:
    feed = feed_of(Script([(1.0, []), (0.75, [Chunk(1, NOISE)]), (0.1, [Chunk(2, NOISE)])]))
    for _ in range(2):
        feed.advance()
    with refused(WrongFormat, ErrorCode.DEVICE, "115200 baud", bytes_seen=128):
        feed.advance()


def test_a_frame_restarts_both_waits() -> None:
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
