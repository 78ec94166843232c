"""Three ports read as one: the bytes of three single-axis gyros, and the samples that they make together.

The gyros run on their own: a sample of x goes with those of y and z nearest to it in time. One of which a part
does not come within 0.5 s, or is more than 0.75 samples off, is not given out.
"""

import select
import time
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drivers.framing import Decoder
from drivers.host_times import HostTimes
from drivers.network_ports import TcpPort
from drivers.serial_port import SerialPort
from drivers.wire import WireFormat, triad
from procedures.counts.sample_records import CountBlock

MAX_OFFSET_PERIODS = 0.75  # sample periods
MAX_LATE_S = 0.5
READ_BYTES = 4096


class AxisSample(NamedTuple):
    """One axis' share of a sample: a count, ``time`` [s] on the host's clock, ``temperature`` [degC]."""

    time: float
    value: int
    temperature: float
    is_healthy: bool


class TriadJoiner:
    """Makes samples of what three axes send; ``missing`` counts those of which a part did not come."""

    def __init__(self, wire: WireFormat) -> None:
        self._decoders = [Decoder(wire) for _ in range(3)]
        self._times = [HostTimes() for _ in range(3)]
        self._parts: list[deque[AxisSample]] = [deque() for _ in range(3)]
        self._stepped = [False] * 3  # an axis' times go on elsewhere with the next of its samples
        self._counter = 0
        self.missing = 0

    def feed(self, axis: int, arrival: float, data: bytes) -> bytes:
        """Return the frames of the samples that these bytes of an axis, read at ``arrival`` [s], complete."""
        block = self._decoders[axis].feed(data)
        if not len(block):
            return b""
        times = self._times[axis].take(arrival, np.ones(len(block), np.int64))
        if self._times[axis].is_reset:
            self._parts[axis].clear()
        if self._times[axis].period is not None:
            columns = (times, block.gyro[:, 0], block.temperature, block.healthy)
            new = [AxisSample(*row) for row in zip(*(each.tolist() for each in columns), strict=True)]
            while self._parts[axis] and self._parts[axis][-1].time >= new[0].time:  # they had run ahead
                self._parts[axis].pop()
            self._parts[axis] += new
        if self._stepped[axis]:  # what was joined of late was not of one moment: a break, whatever comes
            self._counter += 1
            self.missing += 1
        self._stepped[axis] = self._times[axis].has_stepped
        return self._joined(arrival)

    def _joined(self, now: float) -> bytes:
        """Return what is whole by ``now`` [s]."""
        samples = list[tuple[int, tuple[AxisSample, ...]]]()
        period = self._times[0].period
        while period is not None and self._parts[0]:
            x = self._parts[0][0]
            others = [self._nearest(axis, x.time, period, now) for axis in (1, 2)]
            if "wait" in others:
                break
            self._parts[0].popleft()
            whole = (x, *(part for part in others if isinstance(part, AxisSample)))
            if len(whole) == 3:
                samples.append((self._counter, whole))
            elif not self._counter:
                continue  # it begins with the first that is whole
            else:
                self.missing += 1
            self._counter += 1
        return _encoded(samples)

    def _nearest(self, axis: int, at: float, period: float, now: float) -> "AxisSample | str":
        """Return the axis' sample nearest to ``at`` [s], ``missing`` if none is near, ``wait`` if one may be."""
        parts = self._parts[axis]
        while len(parts) > 1 and abs(parts[1].time - at) <= abs(parts[0].time - at):
            parts.popleft()
        if (not parts or parts[-1].time < at - period / 2) and now - at < MAX_LATE_S:  # a nearer one may come
            return "wait"
        return parts[0] if parts and abs(parts[0].time - at) <= MAX_OFFSET_PERIODS * period else "missing"


def _encoded(samples: Sequence[tuple[int, tuple[AxisSample, ...]]]) -> bytes:
    if not samples:
        return b""
    parts = [whole for _, whole in samples]
    faults = np.array([[not part.is_healthy for part in whole] for whole in parts])
    n = len(samples)
    block = CountBlock(
        counter=np.array([counter for counter, _ in samples]),
        device_time=np.array([whole[0].time for whole in parts]),
        gyro=np.array([[part.value for part in whole] for whole in parts]),
        accel=np.zeros((n, 3), np.int64),
        temperature=np.array([np.mean([part.temperature for part in whole]) for whole in parts]),
        status=faults @ np.array([1, 2, 4]),
        healthy=faults.sum(axis=1) == 0,
    )
    return triad.encode(block)


class TriadPort:
    """Three open ports."""

    def __init__(self, ports: Sequence[SerialPort | TcpPort], wire: WireFormat, timeout_s: float) -> None:
        self._ports, self._timeout_s = tuple(ports), timeout_s
        self._joiner = TriadJoiner(wire)
        self._since = time.time_ns() - time.monotonic_ns()

    def read(self, max_bytes: int) -> bytes:
        """Return the frames for what has come on any port, empty after the timeout.

        Raises `LinkLost` if one of the three is gone.
        """
        ready, _, _ = select.select(self._ports, [], [], self._timeout_s)
        frames = list[bytes]()
        for axis, port in enumerate(self._ports):
            if port in ready and (data := port.read(min(max_bytes, READ_BYTES))):
                host_ns = self._since + time.monotonic_ns()
                frames.append(triad.encode_read(host_ns, axis, data))
                frames.append(self._joiner.feed(axis, host_ns / 1e9, data))
        return b"".join(frames)

    def write(self, data: bytes) -> None:
        """Send ``data`` to all three."""
        for port in self._ports:
            port.write(data)

    def close(self) -> None:
        """Give all ports back."""
        for port in self._ports:
            port.close()
