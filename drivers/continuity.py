"""Breaks in the sequence of samples: from the frame counter, or from device time where there is none."""

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.records import CountBlock

LEARNING = 33  # device times from which the sample period is taken


def unwrap(counter: IntArray, modulus: int, last: int | None = None) -> IntArray:
    """Return counters (n,) that do not wrap, going on from the unwrapped ``last`` of the block before.

    Each step is read as the smallest that fits, in [-modulus/2, modulus/2): a step of 0 is a repeated frame,
    a negative one a restarted device.
    """
    if not len(counter):
        return counter.astype(np.int64)
    base = int(counter[0]) if last is None else last
    steps = np.diff(counter, prepend=base % modulus)
    unwrapped: IntArray = base + np.cumsum((steps + modulus // 2) % modulus - modulus // 2)
    return unwrapped


class CounterWatch:
    """Counts the frames whose counter is not one more, modulo ``modulus``, than that of the frame before."""

    def __init__(self, modulus: int) -> None:
        self._modulus = modulus
        self._last: int | None = None

    def jumps(self, block: CountBlock) -> int:
        """Return the number of jumps up to and within the next block."""
        first = int(block.counter[0]) - 1 if self._last is None else self._last
        steps = np.diff(block.counter, prepend=first) % self._modulus
        self._last = int(block.counter[-1])
        return int(np.count_nonzero(steps != 1))


class TimeWatch:
    """Counts the steps of device time that are not above 0 and at most 1.5 periods.

    The period is the median step of the first 33 frames; jumps among those are counted once it is known.
    """

    def __init__(self) -> None:
        self._period: float | None = None
        self._times: FloatArray = np.empty(0)

    def jumps(self, block: CountBlock) -> int:
        """Return the number of jumps found with the next block."""
        times = np.concatenate((self._times, block.device_time))
        steps = np.diff(times)
        if self._period is None:
            if len(times) < LEARNING:
                self._times = times
                return 0
            self._period = float(np.nanmedian(steps[: LEARNING - 1])) if np.isfinite(steps).any() else np.inf
        self._times = times[-1:]
        return int(np.count_nonzero(~((steps > 0) & (steps <= 1.5 * self._period))))
