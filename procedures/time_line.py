"""One clock against another by a robust line, through marks of which some came late or are wrong."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray

LEAST = 6  # marks
BLOCKS = 32


@dataclass(frozen=True, slots=True)
class TimeLine:
    """``reference = reference_0 + rate (clock - clock_0)``, both ends in ns.

    ``scatter`` [s] is the robust 1 sigma of one mark about the line.
    """

    clock_0: int
    reference_0: int
    rate: float
    scatter: float

    def at(self, clock_ns: int) -> float:
        """Return the reference [s] at a moment of the clock [ns]."""
        return self.reference_0 / 1e9 + self.rate * (clock_ns - self.clock_0) / 1e9

    def when(self, reference_ns: int) -> int:
        """Return the moment of the clock [ns] at which the reference says so [ns]."""
        return self.clock_0 + round((reference_ns - self.reference_0) / self.rate)


def fit_time_line(clock_ns: IntArray, reference_ns: IntArray) -> TimeLine | None:
    """Fit a line to marks (n,) of two clocks [ns], the first in order; None where they are too few.

    The slope is the median of the slopes between the medians of up to 32 stretches (Theil and Sen): up to a
    quarter of the marks may be anything. The offset is the marks' median, so that half of them are late of it.
    """
    if len(clock_ns) < LEAST or clock_ns[-1] <= clock_ns[0]:
        return None
    x, y = (clock_ns - clock_ns[0]) / 1e9, (reference_ns - reference_ns[0]) / 1e9
    stretches = np.array_split(np.arange(len(x)), min(BLOCKS, len(x)))
    centre: FloatArray = np.array([[np.median(x[s]), np.median(y[s])] for s in stretches])
    i, j = np.triu_indices(len(centre), 1)
    dx, dy = (centre[j] - centre[i]).T
    apart = dx > 0
    if not apart.any():
        return None
    rate = float(np.median(dy[apart] / dx[apart]))
    left = y - rate * x
    offset = float(np.median(left))
    scatter = 1.4826 * float(np.median(np.abs(left - offset)))
    return TimeLine(int(clock_ns[0]), int(reference_ns[0]) + round(offset * 1e9), rate, scatter)
