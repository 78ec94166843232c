"""A faulty line polled in memory, in device time: what a reader process hands on, cut anywhere, seeded."""

from collections.abc import Iterable

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.can.can_format import can_format
from drivers.can.frame_record import RECORD, pack, unpack
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault, Silence
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, WireFormat
from procedures.arrays import IntArray
from procedures.counts.sample_records import SampleBlock
from station.stream.reader import Chunk, StreamGap

PERIOD = 0.02
TRUTH = Truth(sample_period_s=PERIOD, accel_noise_g=0.3, gyro_arw_deg_rt_s=0.01)  # no sample like another
LONGEST = 5  # samples between two looks


class LineInMemory:
    """A device's bytes as they come; each poll ends after 20 to 100 ms of device time, cut at any byte.

    ``format`` is a serial format or ``can``. The clock [s] is the device's.
    """

    def __init__(self, format: str, faults: Iterable[Fault], seed: int = 1) -> None:
        is_can = format == "can"
        self.wire: WireFormat = can_format(period=PERIOD) if is_can else FORMATS[format]
        where = "can://udp_multicast/239.0.0.1" if is_can else f"serial:///dev/imu?format={format}"
        self.address: DeviceAddress = parse_device_url(where)
        self._device = ByteDevice(TRUTH, seed, self.wire, faults)
        self._rng = np.random.default_rng(seed)
        self._grain = RECORD.itemsize if is_can else 1
        self._waiting = b""
        self._back_at: float | None = None

    def clock(self) -> float:
        """Return the device's time [s]."""
        return self._device.imu.time

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return what has come."""
        parts = self._device.chunk(int(self._rng.integers(1, LONGEST + 1)))
        now, items, before = self.clock(), list[Chunk | StreamGap](), len(self._waiting)
        stamp = round(now * 1e9)
        for part in parts:
            if isinstance(part, bytes):
                self._waiting += part if self._grain == 1 else self._received(part, stamp)
            elif part.kind == "unplug":
                self._waiting, self._back_at = b"", now + part.seconds
                items.append(StreamGap(stamp, "port lost: gone", False))
        if self._back_at is not None and now >= self._back_at:
            self._back_at = None
            items.append(StreamGap(stamp, "port back", True))
        if data := self._cut(is_idle=len(self._waiting) == before):
            items.append(Chunk(stamp, data))
        return items

    def _received(self, frames: bytes, stamp: int) -> bytes:
        whole = frames if len(frames) % RECORD.itemsize == 0 and frames.startswith(b"\xca\x4e") else b""
        return b"".join(pack(identifier, stamp, data) for identifier, data in unpack(whole))

    def _cut(self, *, is_idle: bool) -> bytes:
        size = len(self._waiting) // self._grain
        size = size if is_idle else int(self._rng.integers(size + 1))
        data, self._waiting = self._waiting[: size * self._grain], self._waiting[size * self._grain :]
        return data


class Memory:
    """What is true of the first samples."""

    def __init__(self, samples: int, seed: int = 1) -> None:
        block = SimulatedImu(TRUTH, seed).read(samples)
        self._which = {row.tobytes(): i for i, row in enumerate(np.hstack((block.gyro, block.accel)))}
        assert len(self._which) == samples

    def which(self, block: SampleBlock) -> IntArray:
        """Return which samples of the truth these are, -1 none."""
        rows = np.hstack((block.gyro, block.accel))
        return np.array([self._which.get(row.tobytes(), -1) for row in rows], dtype=np.int64)


__all__ = ["PERIOD", "TRUTH", "LineInMemory", "Memory", "Silence"]
