"""A simulated unit, polled in memory, whose samples are calibrated as they are handed on."""

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from drivers.framing import Decoder
from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.campaign.campaign import UNKNOWN
from procedures.counts.sample_records import SampleBlock, joined_blocks
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration
from station.sending.live_samples import LiveSamples
from station.sending.outputs import CalibratedSamples
from station.stream.live.live_feed import open_feed
from station.stream.reader import Chunk, StreamGap
from tests.station.monitor.unit import calibration_of
from tests.station.stream.live.bench_in_memory import Source

UNIT = replace(Truth.example(5), sample_period_s=0.01)


class KeptSource(Source):
    """Keeps the bytes that it gave."""

    data = b""

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        items = super().poll(timeout_s)
        self.data += b"".join(item.data for item in items if isinstance(item, Chunk))
        return items


class LiveRig:
    """`run` lets device time pass and returns what was handed on, end to end."""

    def __init__(
        self, faults: Iterable[Fault] = (), calibration: dict[str, Any] | None = None, truth: Truth = UNIT,
        format: str = "counts", count_bits: int = 32, **options: Any,
    ) -> None:  # fmt: skip
        self.source = KeptSource(truth, faults, format)
        self.feed = open_feed(self.source)
        self.feed.wire = replace(self.feed.wire, count_bits=count_bits)
        unknown = UNKNOWN if self.feed.wire.identity is None else None
        self.feed.identify(unknown, unknown)
        applied = AppliedCalibration(calibration or calibration_of(truth), None, InUse("by hand"))
        self.samples = LiveSamples(self.feed, applied, np.eye(3), **options)

    def run(self, seconds: float) -> CalibratedSamples:
        end, found = self.source.device.imu.time + seconds, list[CalibratedSamples]()
        while self.source.device.imu.time < end:
            taken = self.samples.take(self.source.device.imu.time)
            found += [] if taken is None else [taken]
            self.feed.buffer.forget_before(self.feed.buffer.end)
            self.feed.advance()
        return joined(found)

    def sent(self) -> SampleBlock:
        """Return what the device has sent, decoded at once."""
        decoder = Decoder(FORMATS[self.feed.wire.name])
        return joined_blocks([decoder.feed(self.source.data)])


def joined(parts: list[CalibratedSamples]) -> CalibratedSamples:
    columns = {
        f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(CalibratedSamples)
    }
    return CalibratedSamples(**columns)
