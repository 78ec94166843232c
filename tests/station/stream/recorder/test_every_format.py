"""Every wire format from a device's bytes to a recording and back: found by sniffing, recorded, decoded again."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from drivers.address_parsing import parse_device_url
from drivers.errors import ReplayEnded
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, WireFormat
from station.files.mcap_files import COUNTS, RATES, read_step
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.reader import Chunk
from station.stream.recorder import plain_recording
from station.stream.recorder.sample_stream import SampleStream, check_raw_bytes
from tests.drivers.wire.blocks import each_format
from tests.station.stream.live.bench_in_memory import Source

every_format = each_format()
TRUTH = Truth.example(3)
PERIOD = TRUTH.sample_period_s


class Unnamed(Source):
    """A device whose address names no format, in reads of any size, for a while."""

    def __init__(self, wire: WireFormat, samples: int, faults: tuple[Fault, ...] = ()) -> None:
        super().__init__(TRUTH, faults, format=wire.name)
        self.address = parse_device_url("serial:///dev/simulated")
        self.rng, self.left = np.random.default_rng(1), samples

    def poll(self, timeout_s: float) -> list[Chunk]:
        if self.left <= 0:
            raise ReplayEnded("simulated", 0)
        items = list[Chunk]()
        for part in self.device.chunk(10):
            assert isinstance(part, bytes)
            late = round(1e9 * (self.device.imu.time + abs(self.rng.normal(0, 2e-4))))
            cut = int(self.rng.integers(0, len(part) + 1))
            items += [Chunk(late, piece) for piece in (part[:cut], part[cut:]) if piece]
        self.left -= 10
        return items


@every_format
def test_what_a_device_sends_is_recognised_recorded_and_decoded_again(wire: WireFormat, tmp_path: Path) -> None:
    feed = open_feed(Unnamed(wire, 1500))
    assert feed.wire is wire
    done = plain_recording.record(feed, tmp_path, float("inf"))
    contents = read_step(done.path)
    assert done.samples == len(contents) == check_raw_bytes(done.path, wire)
    assert done.samples >= 1400  # what came before the format was known is not in it
    assert contents.output == (RATES if wire.output == "rate" else COUNTS)
    for triad in ("gyro", "accel"):
        assert (getattr(contents, triad) is not None) == (triad in wire.imu.triads)
    steps = np.diff(contents.device_ns[200:]) / 1e9  # once the period is known
    assert np.median(steps) == pytest.approx(PERIOD, rel=1e-3)
    assert (contents.device_ns[-1] - contents.device_ns[200]) / 1e9 == pytest.approx(
        PERIOD * (len(contents) - 201), rel=1e-4
    )
    counters = feed.stream.counters
    assert (counters.lost, counters.repeated, counters.breaks) == (0, 0, 0)
    assert counters.restarts == 0 if wire.imu.has_time else counters.restarts <= 1


@every_format
def test_lost_frames_are_a_break(wire: WireFormat) -> None:
    faults = (Fault("lost", at_s=10.0, count=3),)
    feed = LiveFeed(Unnamed(wire, 1000, faults), wire)
    pieces = list(_pieces(feed))
    assert feed.stream.counters.breaks == 1
    assert sum(len(piece.block) for piece in pieces) == 997
    times = np.concatenate([piece.block.device_time for piece in pieces])
    assert times[-1] - times[400] == pytest.approx(599 * PERIOD, abs=PERIOD / 5 if wire.imu.has_time else PERIOD)
    assert np.all(np.diff(times[300:]) > 0)


def _pieces(feed: LiveFeed) -> Iterator:
    try:
        yield from feed.pieces()
    except ReplayEnded:
        return


def test_a_stim300_s_time_goes_on_over_its_turn_of_0_128_s() -> None:
    wire, device = FORMATS["stim300"], ByteDevice(TRUTH, 1, "stim300")
    stream = SampleStream(wire)
    times = np.concatenate(
        [stream.take(Chunk(i, part)).block.device_time for i in range(10) for part in device.chunk() if part]
    )
    np.testing.assert_allclose(np.diff(times), PERIOD, atol=1e-9)
