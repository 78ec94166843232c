"""A feed whose polls are written down: what it waits for, to the tenth of a second, and what it keeps."""

import time
from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from drivers.device_url_parser import parse_device_url
from drivers.errors import BadDeviceUrl, LinkLost, LinkSilent, ReplayEnded, WrongFormat
from drivers.simulated.device import ByteDevice
from drivers.simulated.line_faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock
from station.errors import DataRefused
from station.stream.live.live_feed import TEMPERATURE_SAMPLES, LiveFeed, open_feed
from station.stream.live.stillness import TICKS_PER_BLOCK, Block
from station.stream.reader import Chunk, GapMark
from station.stream.recorder.sample_stream import DecodedChunk
from tests.station.stream.live.bench_in_memory import Source

Item = Chunk | GapMark
NOISE = bytes(64)
GONE, BACK = GapMark(5, "port lost: unplugged", False), GapMark(6, "port back", True)
TRIAD = "triad:?x=serial:///dev/x&y=serial:///dev/y&z=serial:///dev/z"
PERIOD = 0.02


class Script:
    """Each poll takes some seconds of the station's and brings something; after the last, nothing comes."""

    def __init__(self, polls: Iterable[tuple[float, list[Item]]] = (), url: str = "") -> None:
        self.address = parse_device_url(url or "serial:///dev/imu?format=counts&baud=115200")
        self.polls = deque(polls)
        self.now = 0.0

    def poll(self, timeout_s: float) -> list[Item]:
        seconds, items = self.polls.popleft() if self.polls else (timeout_s, [])
        self.now += seconds
        return items

    def clock(self) -> float:
        return self.now


def feed_of(script: Script, format: str = "counts") -> LiveFeed:
    return LiveFeed(script, FORMATS[format], clock=script.clock)


def device(period: float = PERIOD, faults: Iterable[Fault] = (), format: str = "counts") -> ByteDevice:
    return ByteDevice(Truth(sample_period_s=period), 1, format, faults)


def chunks(one: ByteDevice, samples: int) -> list[Item]:
    """Return what a device sends, a chunk a sample."""
    found = list[Item]()
    while one.samples < samples:
        data = b"".join(part for part in one.chunk(1) if isinstance(part, bytes))
        found.append(Chunk(round(one.imu.time * 1e9), data))
    return found


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


def warm(values: FloatArray) -> DecodedChunk:
    n = len(values)
    whole, times = np.zeros((n, 3), np.int64), PERIOD * np.ones(n).cumsum()
    block = CountBlock(np.arange(n), times, whole, whole, values, np.zeros(n, np.int64), values > 0)
    return DecodedChunk(Chunk(0, b""), block, np.zeros((n, 2), np.int64), np.zeros(0, np.int64), None)


def told(feed: LiveFeed) -> float | None:
    return feed.temperature_c


def test_the_temperature_is_the_newest_that_was_told_lately() -> None:
    feed = feed_of(Script())
    assert told(feed) is None
    feed.buffer.append(warm(np.array([20.0, 21.0, np.nan])))
    assert told(feed) == 21.0
    feed.buffer.append(warm(np.full(TEMPERATURE_SAMPLES - 2, np.nan)))
    assert told(feed) == 21.0
    feed.buffer.append(warm(np.full(1, np.nan)))
    assert told(feed) is None
    feed.buffer.append(warm(np.array([25.0])))
    assert told(feed) == 25.0
    feed.buffer.forget_before(feed.buffer.end)
    assert told(feed) is None


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


def test_pieces_come_once_each_and_no_sample_is_kept() -> None:
    items = chunks(device(), 30)
    script = Script([(0.0, items[:10]), (0.0, []), (0.0, items[10:])])
    feed, looks, counters = feed_of(script), list[int](), list[int]()
    for piece in feed.pieces(lambda: looks.append(feed.buffer.first)):
        counters += piece.block.counter.tolist()
        if len(counters) == 30:
            break
    assert counters == list(range(30))
    assert looks == [0, 10, 10]


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("mavlink:udpin:127.0.0.1:14550", "a MAVLink link; expected an IMU's, such as /dev/ttyUSB0; --gnss"),
        ("camera:http://127.0.0.1:5000/x", "a camera; expected an IMU's, such as /dev/ttyUSB0; --camera"),
    ],
)  # fmt: skip
def test_the_address_of_something_else_is_refused_with_where_it_belongs(url: str, said: str) -> None:
    with pytest.raises(BadDeviceUrl, match=f"the address of {said}"):
        open_feed(Script(url=url))


SNIFFED = "serial:///dev/imu"


def test_a_format_is_found_by_three_frames_and_these_are_the_first_samples() -> None:
    script = Script([(0.0, [each]) for each in chunks(device(format="rawimus"), 5)], SNIFFED)
    feed = open_feed(script)
    assert feed.wire.name == "rawimus"
    assert (feed.buffer.end, len(script.polls)) == (3, 2)
    assert [len(piece.block) for piece, _ in zip(feed.pieces(), range(3), strict=False)] == [1, 1, 1]


@pytest.mark.parametrize(
    ("items", "refused", "said"),
    [
        ([], LinkSilent, r"no bytes for 1\.8 s"),
        ([Chunk(1, NOISE), GONE, Chunk(2, NOISE)], WrongFormat, "128 bytes at 921600 baud hold no frame of any"),
    ],
)
def test_a_format_that_is_not_found_in_time_is_refused(
    items: list[Item], refused: type[Exception], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = Script([(0.0, [each]) for each in items], SNIFFED)
    monkeypatch.setattr(time, "monotonic", script.clock)
    with pytest.raises(refused, match=said):
        open_feed(script)
    assert 1.8 <= script.now < 1.95


def test_a_recording_that_ends_before_its_format_is_found_is_refused() -> None:
    class Ended(Script):
        def poll(self, timeout_s: float) -> list[Item]:
            raise ReplayEnded("a.mcap", 7)

    with pytest.raises(DataRefused, match="7 bytes without enough frames of any known format"):
        open_feed(Ended(url=SNIFFED))
