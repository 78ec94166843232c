"""One clock against another by a robust line, through marks of which some came late or are wrong.

`fit_time_line` goes through the middle of the marks, `fit_earliest_line` along those that came least late: their
delays move with all that the machine has to do, the least of them hardly.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray

MIN_MARKS = 6  # marks
MAX_STRETCHES = 32
# Scatters, and seconds of the clock, that a mark may be before the middle ones
MAX_AHEAD_SCATTERS, MAX_AHEAD_S = 8.0, 0.05


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
    """Fit a line to marks ``clock_ns``, ``reference_ns`` (n,) [ns] of two clocks, the first in order.

    None where they are too few. The slope is the median of the slopes between the medians of up to 32 stretches
    (Theil and Sen): up to a quarter of the marks may be anything. The offset is the marks' median, so that half of
    them are late of it.
    """
    if len(clock_ns) < MIN_MARKS or clock_ns[-1] <= clock_ns[0]:
        return None
    x, y = (clock_ns - clock_ns[0]) / 1e9, (reference_ns - reference_ns[0]) / 1e9
    stretches = np.array_split(np.arange(len(x)), min(MAX_STRETCHES, len(x)))
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


def fit_earliest_line(clock_ns: IntArray, reference_ns: IntArray) -> TimeLine | None:
    """Fit a line to marks ``clock_ns``, ``reference_ns`` (n,) [ns], read late by the clock, never early.

    None where they are too few. No mark lies above it but those that are far ahead of the middle ones, as of a
    reference that was set wrong for a while: it is the edge of the marks' convex hull over their mean.
    """
    line = fit_time_line(clock_ns, reference_ns)
    if line is None:
        return None
    x, y = (clock_ns - clock_ns[0]) / 1e9, (reference_ns - reference_ns[0]) / 1e9
    off = y - line.rate * x
    off -= np.median(off)
    keep = off <= max(MAX_AHEAD_SCATTERS * line.scatter, MAX_AHEAD_S * line.rate)
    x, off = x[keep], off[keep]
    hull = _upper_hull(x, off)
    right = min(max(int(np.searchsorted(x[hull], x.mean())), 1), len(hull) - 1)
    a, b = hull[right - 1], hull[right]
    slope = float((off[b] - off[a]) / (x[b] - x[a]))
    middle = float(np.median(y - line.rate * (clock_ns - clock_ns[0]) / 1e9))
    offset = middle + float(off[a] - slope * x[a])
    return TimeLine(int(clock_ns[0]), int(reference_ns[0]) + round(offset * 1e9), line.rate + slope, line.scatter)


def _upper_hull(x: FloatArray, y: FloatArray) -> list[int]:
    """Return the points of the upper convex hull of points in order of x; of equal x the highest."""
    hull = list[int]()
    for i in range(len(x)):
        if hull and x[i] == x[hull[-1]]:
            if y[i] <= y[hull[-1]]:
                continue
            hull.pop()
        while len(hull) > 1 and _is_below(x, y, hull[-2], hull[-1], i):
            hull.pop()
        hull.append(i)
    return hull


def _is_below(x: FloatArray, y: FloatArray, a: int, b: int, c: int) -> bool:
    return bool((y[b] - y[a]) * (x[c] - x[a]) <= (y[c] - y[a]) * (x[b] - x[a]))
