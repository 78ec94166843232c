"""A live feed in memory: another source, temperature, pulses, pieces, and a format that is found."""

import time

import numpy as np
import pytest

from drivers.errors import BadDeviceUrl, LinkSilent, ReplayEnded, WrongFormat
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock
from station.errors import DataRefused
from station.stream.live.live_feed import TEMPERATURE_SAMPLES, LiveFeed, open_feed
from station.stream.reader import Chunk
from station.stream.recorder.sample_stream import DecodedChunk
from tests.station.stream.live.bench_in_memory import Source
from tests.station.stream.live.scripted_feed import GONE, NOISE, PERIOD, Item, Script, chunks, device, feed_of


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
