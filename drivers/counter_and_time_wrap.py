"""Breaks in the sequence of samples: from the frame counter, or from device time where there is none."""

import numpy as np

from drivers.wire import WireFormat
from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import SampleBlock
from procedures.counts.sample_times import GAP_PERIODS

MIN_MODULUS, MIN_TURN_S = 1024, 60.0  # a counter or a clock [s] that turns sooner is read as never going back
PERIOD_SAMPLES = 33  # device times from which the sample period is taken


def unwrap(counter: IntArray, modulus: int, last: int | None = None) -> IntArray:
    """Return numbers (n,) of frames that do not wrap, of ``counter`` (n,), from the unwrapped ``last`` on.

    Each step is read as the smallest that fits, in [-modulus/2, modulus/2): a step of 0 is a repeated frame,
    a negative one a restarted device. A counter of few bits is read as going on, in [0, modulus): with 128 half a
    turn is 64 ms at 1 kHz, and a gap that long is likelier than a restart.
    """
    back = modulus // 2 if modulus >= MIN_MODULUS else 0
    if not len(counter):
        return counter.astype(np.int64)
    base = int(counter[0]) if last is None else last
    steps = np.diff(counter, prepend=base % modulus)
    unwrapped: IntArray = base + np.cumsum((steps + back) % modulus - back)
    return unwrapped


def unwrap_steps(seconds: FloatArray, modulus: float | None) -> FloatArray:
    """Return ``seconds`` (n,), steps of device time, as the smallest (n,) [s] that fit a wrap at ``modulus``.

    One that turns within `MIN_TURN_S` is read as going on, as a counter of few bits is. Seconds are rounded to
    0.1 us before and after: a repeat's step would else come out as just next to 0, or as a whole turn.
    """
    if modulus is None:
        return seconds
    back = modulus / 2 if modulus >= MIN_TURN_S else 0.0
    steps = np.round((np.round(seconds, 7) + back) % modulus - back, 7)
    within: FloatArray = np.where(steps < modulus - back, steps, steps - modulus)
    return within


class CounterWatch:
    """Counts the frames whose counter is not one more, modulo ``modulus``, than that of the frame before."""

    def __init__(self, modulus: int) -> None:
        self._modulus = modulus
        self._last: int | None = None

    def jumps(self, block: SampleBlock) -> int:
        """Return the number of jumps up to and within the next block."""
        first = int(block.counter[0]) - 1 if self._last is None else self._last
        steps = np.diff(block.counter, prepend=first) % self._modulus
        self._last = int(block.counter[-1])
        return int(np.count_nonzero(steps != 1))


class TimeWatch:
    """Counts the steps of device time that are not above 0 and at most 1.5 periods.

    The period is the median step of the first 33 frames; jumps among those are counted once it is known. Device
    time that begins again every ``modulus`` [s] is read as going on.
    """

    def __init__(self, modulus: float | None = None) -> None:
        self._modulus = modulus
        self._period: float | None = None
        self._times: FloatArray = np.empty(0)

    def jumps(self, block: SampleBlock) -> int:
        """Return the number of jumps found with the next block."""
        times = np.concatenate((self._times, block.device_time))
        steps = unwrap_steps(np.diff(times), self._modulus)
        if self._period is None:
            if len(times) < PERIOD_SAMPLES:
                self._times = times
                return 0
            self._period = float(np.nanmedian(steps[: PERIOD_SAMPLES - 1])) if np.isfinite(steps).any() else np.inf
        self._times = times[-1:]
        return int(np.count_nonzero(~((steps > 0) & (steps <= GAP_PERIODS * self._period))))


class StepGate:
    """Marks as unhealthy what is too far from the last healthy sample: a second look where the check is weak.

    ``most`` is what a channel can change by from one sample to the next; for each sample passed over as much more
    is allowed, so that no first sample, however wrong, shuts out the rest.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._last: FloatArray | IntArray | None = None
        self._shut = 0  # samples since the last healthy one

    def shut(self, block: SampleBlock) -> None:
        """Clear ``healthy`` of the samples of the next block that step too far."""
        values = np.hstack((block.gyro, block.accel))
        last = values[0] if self._last is None else self._last
        if self._shut or (np.abs(np.diff(values, axis=0, prepend=last[None])) > self._most).any():
            for row, value in enumerate(values):
                if np.abs(value - last).max() <= self._most * (1 + self._shut):
                    last, self._shut = value, 0
                else:
                    block.healthy[row] = False
                    self._shut += 1
            self._last = last
        else:
            self._last = values[-1]


def continuity_watch(wire: WireFormat) -> CounterWatch | TimeWatch | None:
    """Return what sees breaks in a format's frames; None where neither counter nor time shows them."""
    if wire.counter_modulus is not None:
        return CounterWatch(wire.counter_modulus)
    return TimeWatch(wire.time_modulus) if "device_time" in wire.carries else None
