"""When samples were taken: reference pulses in a device's frames, UTC of rows, and the station's own clock.

`PulseAges` gives how long before the last sample of a chunk a reference pulse (PPS) came. `RowTimes` gives UTC of
the rows that came last in a chunk, each with the jitter of its own reading, so that a fit over many of them
(`procedures.counts.reference_time`) sees their scatter; a smooth line through them would hide it. A pulse is a
whole second, latched by the device itself to a microsecond: it is then the reference. Which second it is follows
from the first reading and then from the device's own time; where that reading was this machine's clock, it is
replaced as soon as UTC is known. `SampleMoments` gives when a sample was taken by the station's clock.
"""

from collections import deque
from collections.abc import Callable, Collection

from drivers.wire import PulseForm
from procedures.counts.sample_records import SampleBlock
from station.files.mcap_files import StepWriter
from station.stream.reader import Chunk

MAX_FRAME = 1024  # bytes: more than any format's frame


class PulseAges:
    """Chunks in order; ``form`` is None where the format reports no pulse."""

    def __init__(self, form: PulseForm | None) -> None:
        self._form, self._before = form, b""

    def of(self, data: bytes, block: SampleBlock) -> float | None:
        """Return how old [s] the pulse is at the last sample of ``block``, which ``data`` completed, if known."""
        if self._form is None:
            return None
        together = self._before + data
        self._before = together[-MAX_FRAME:]
        return self._form.age(together, float(block.device_time[-1])) if len(block) else None


Utc = Callable[[int], float | None]
MIN_INTERVAL_NS = 50_000_000  # at most 20 rows a second
PULSED_NS = 3 * 10**9  # so long after a pulse nothing less is taken for a reference
MAX_PULSE_JITTER_S = 0.05  # s by which seconds may lie off each other by the device's own time


class RowTimes:
    """UTC [s] for chunks in order, from what a moment of the station's clock [ns] was in UTC.

    ``is_pulsed`` says whether the last one came from a pulse.
    """

    def __init__(self, utc: Utc | None) -> None:
        self._utc = utc
        self._next_ns = 0
        self._pulse: tuple[int, float] | None = None  # the second of the last one, and its device time [s]
        self._is_by_host = False  # that second
        self._pulsed_ns = -PULSED_NS
        self.is_pulsed = False

    def reset(self) -> None:
        """Forget the last pulse: the device's time has no relation to what it was."""
        self._pulse, self._pulsed_ns = None, -PULSED_NS

    def of(self, host_ns: int, device_s: float = 0.0, pulse_age: float | None = None) -> float | None:
        """Return UTC of a chunk's last row; None where it is not known or the one before was just now.

        ``device_s`` is the row's own time, ``pulse_age`` how long before it a pulse came [s], None: not stated.
        """
        if host_ns < self._next_ns:
            return None
        self.is_pulsed = pulse_age is not None or host_ns < self._pulsed_ns + PULSED_NS
        if pulse_age is not None:
            self._next_ns, self._pulsed_ns = host_ns + MIN_INTERVAL_NS, host_ns
            return self._second(host_ns, device_s - pulse_age, pulse_age) + pulse_age
        if self._utc is None or self.is_pulsed:
            return None
        self._next_ns = host_ns + MIN_INTERVAL_NS
        return self._utc(host_ns)

    def _second(self, host_ns: int, pulse_s: float, age: float) -> int:
        """Return which second a pulse is that came at the device's time ``pulse_s`` [s]."""
        if self._pulse is not None:
            second, at = self._pulse
            passed = round(pulse_s - at)
            off = abs(pulse_s - at - passed)
        # the first, after a gap that nothing counted, or of a time that went back
        is_lost = self._pulse is None or off > MAX_PULSE_JITTER_S or passed < 0
        if is_lost or self._is_by_host:
            read = None if self._utc is None else self._utc(host_ns)
            if is_lost or read is not None:
                second, passed = round((host_ns / 1e9 if read is None else read) - age), 0
            self._is_by_host = read is None
        self._pulse = second + passed, pulse_s
        return second + passed


class StepRows:
    """Writes chunks in order: bytes, and the rows that they completed, with UTC where it is known.

    ``pulse`` reads reference pulses of the device; None where its format reports none.
    """

    def __init__(self, writer: StepWriter, times: RowTimes, pulse: PulseForm | None) -> None:
        self._writer, self._times, self._pulses = writer, times, PulseAges(pulse)

    def write(self, chunk: Chunk, block: SampleBlock, triads: Collection[str] = ("gyro", "accel")) -> None:
        """Write a chunk; ``block`` holds the rows that it completed."""
        self._writer.write_raw(chunk.host_ns, chunk.data)
        age = self._pulses.of(chunk.data, block)
        if len(block):
            utc_s = self._times.of(chunk.host_ns, float(block.device_time[-1]), age)
            self._writer.write_block(chunk.host_ns, block, triads, utc_s)


LAG_TICKS = 600
FEWEST_TICKS = 50
PERIOD_MISMATCH = 0.02  # a clock is a thousand times better: the device's sample period is not the stated one


class SampleMoments:
    """When a sample was taken, by the station's clock; learnt from ticks in order, the same in a replay.

    A read is never before its last sample: the least that reads lag behind the device's clock is the link's own
    delay. It is taken from the last minute, in which the two clocks drift apart by milliseconds. The lag grows
    behind a device that goes slower than it says: it is then a line through the least of either half minute.
    """

    def __init__(self) -> None:
        self._lags: deque[tuple[int, int]] = deque(maxlen=LAG_TICKS)  # ns: how much, and the device's time

    def reset(self) -> None:
        """Forget the lag: the device's clock may have restarted."""
        self._lags.clear()

    def of(self, t: float, read_ns: int) -> int:
        """Return the moment [ns] of a sample at device time ``t`` [s], in bytes that were read at ``read_ns``."""
        device_ns = round(t * 1e9)
        self._lags.append((read_ns - device_ns, device_ns))
        return device_ns + self._lag(device_ns)

    def _lag(self, device_ns: int) -> int:
        lags = list(self._lags)
        if len(lags) >= FEWEST_TICKS:
            half = len(lags) // 2
            (before, begin), (least, at) = min(lags[:half]), min(lags[half:])
            if (grows := (least - before) / (at - begin)) > PERIOD_MISMATCH:
                return min(lags[-1][0], least + round(grows * (device_ns - at)))
        return min(lags)[0]
