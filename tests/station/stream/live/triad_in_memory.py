"""Three single-axis gyros joined as one, one of them faulty: polled in memory, in the station's time.

Each count says which sample of which axis it is; another unit's say something else.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.simulated.faults import Fault, FaultyLine
from drivers.triad_port import TriadJoiner
from drivers.wire import FORMATS, WireFormat, triad
from procedures.arrays import IntArray
from procedures.counts.sample_records import CountBlock, SampleBlock
from station.stream.reader import Chunk, StreamGap

PERIOD = 0.01
AXIS = FORMATS["ch70"]
BASE = 100.0  # s: the host's clock when the gyros begin
LATE_S = 1e-4  # of the bytes, on average


class TriadInMemory:
    """What the port of a triad gives, each poll 30 to 80 ms; ``faults`` are those of the gyro ``axis``."""

    def __init__(self, axis: int, faults: Iterable[Fault], seed: int = 1) -> None:
        self.wire: WireFormat = FORMATS["triad"]
        self.address: DeviceAddress = parse_device_url(
            "triad:?x=serial:///dev/x&y=serial:///dev/y&z=serial:///dev/z"
        )
        planted: Sequence[Sequence[Fault]] = [list(faults) if k == axis else [] for k in range(3)]
        self._lines = [FaultyLine(AXIS, planted[k], PERIOD, seed) for k in range(3)]
        self._joiner, self._rng, self._sent = TriadJoiner(AXIS), np.random.default_rng(seed), 0

    def clock(self) -> float:
        """Return the gyros' time [s]."""
        return self._sent * PERIOD

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return what has come."""
        first, n = self._sent, int(self._rng.integers(3, 9))
        self._sent += n
        now, frames = BASE + self.clock() + float(self._rng.exponential(LATE_S)), b""
        for axis, line in enumerate(self._lines):
            if data := b"".join(part for part in line.send(block(axis, first, n)) if isinstance(part, bytes)):
                host_ns = round(now * 1e9) + 1000 * axis
                frames += triad.encode_read(host_ns, axis, data) + self._joiner.feed(axis, host_ns / 1e9, data)
        return [Chunk(round(now * 1e9), frames)] if frames else []


def block(axis: int, first: int, n: int) -> CountBlock:
    """Return an axis' samples."""
    number = np.arange(first, first + n)
    gyro = np.zeros((n, 3), np.int64)
    gyro[:, 0] = 3 * number + axis
    nothing = np.zeros(n)
    return CountBlock(number, PERIOD * number, gyro, 0 * gyro, nothing + 20, np.zeros(n, np.int64), nothing == 0)


def which(block: SampleBlock) -> IntArray:
    """Return which sample each axis' share is, (n, 3); -1 none of this gyro's."""
    number, axis = np.divmod(block.gyro.astype(np.int64), 3)
    shares: IntArray = np.where((number >= 0) & (axis == np.arange(3)), number, -1)
    return shares
