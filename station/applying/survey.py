"""The times of a source, looked at before anything is written: that they rise, and how far apart samples are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.sample_times import GAP_PERIODS, own_period
from procedures.error_codes import ErrorCode
from station.applying.source import Source, Told
from station.errors import DataRefused

PACE_SAMPLES = 200_000  # of which it is told at first how far apart samples are
MEAN_TOLERANCE = 1e-3  # relative, of the mean step against that: beyond it stamps are no times of samples
TOLERANCE = 0.01  # relative, of the period that a source states


@dataclass(frozen=True, slots=True)
class Survey:
    """How many samples there are at most, from when to when [s], and the period [s] of one."""

    rows: int
    first: float
    last: float
    period: float


def survey(source: Source) -> Survey:
    """Look at all times of a source.

    Raises
    ------
    DataRefused
        If time goes back, never moves, or is more than 1 % off the pace that the source states.
    """
    rows, first, last = 0, np.nan, -np.inf
    head, pace, total, steps = list[FloatArray](), 0.0, 0.0, 0
    for stamps, where, lines in source.times():
        t = stamps[np.isfinite(stamps)]
        if not len(t):
            continue
        step = np.diff(t, prepend=last)
        if (back := np.flatnonzero(step < 0)).size:
            raise _goes_back(where, lines, stamps, t, int(back[0]), last)
        rows, first, last = rows + len(t), float(t[0]) if np.isnan(first) else first, float(t[-1])
        if not pace:
            head.append(t)
            if rows >= PACE_SAMPLES:
                pace = own_period(_rising(np.concatenate(head), source.told))
                step, head = np.diff(np.concatenate(head)), []
        if pace:
            inside = step[(step > 0) & (step <= GAP_PERIODS * pace)]
            total, steps = total + float(inside.sum()), steps + len(inside)
    if rows < 2:
        what = f"{'a single' if rows else 'no'} sample with a time"
        raise DataRefused(source.told.name, None, what, "two at least", "name another", code=ErrorCode.TOO_SHORT)
    if head:
        pace = own_period(_rising(np.concatenate(head), source.told))
    mean = total / steps if steps else pace
    found = mean if abs(mean / pace - 1) < MEAN_TOLERANCE else pace
    told = source.told.period
    if told is not None and abs(found / told - 1) > TOLERANCE:
        said = f"a sample rate of {1 / found:.6g} Hz by the times, {found / told - 1:+.1%} of the period"
        raise DataRefused(source.told.name, None, said, f"{1 / told:.6g} Hz as stated, within 1 %", "correct one")
    return Survey(rows, first, last, found)


def _rising(t: FloatArray, told: Told) -> FloatArray:
    found = np.unique(t)
    if len(found) < 2:
        raise DataRefused(told.name, None, "a time that never changes", "times that rise", "state --rate HZ",
                          ErrorCode.TIME_ORDER)  # fmt: skip
    return found


def _goes_back(
    where: str, lines: Sequence[int], stamps: FloatArray, t: FloatArray, at: int, last: float
) -> DataRefused:
    row = int(np.flatnonzero(np.isfinite(stamps))[at])
    before = t[at - 1] if at else last
    expected = "times that rise from row to row"
    place = lines[row] if lines else None
    return DataRefused(
        where, place, f"time {t[at]:.9g} after {before:.9g}", expected, "cut it in two there", ErrorCode.TIME_ORDER
    )
