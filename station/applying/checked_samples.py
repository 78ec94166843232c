"""Samples checked before use: times rise at an even rate, no missing numbers, running counts made increments."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, finite_rows
from procedures.counts.missing_rows import MAX_BRIDGED, sentinel_cells
from procedures.counts.sample_times import GAP_PERIODS, own_period
from procedures.errors import ErrorCode
from station.applying.source import Samples, Source, Stated
from station.errors import DataRefused

RATE_SAMPLES = 200_000  # from which the sample period is estimated first
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

    Raise `DataRefused` if time goes back, never moves, or is more than 1 % off the pace that the source states.
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
            if rows >= RATE_SAMPLES:
                pace = own_period(_rising(np.concatenate(head), source.stated))
                step, head = np.diff(np.concatenate(head)), []
        if pace:
            inside = step[(step > 0) & (step <= GAP_PERIODS * pace)]
            total, steps = total + float(inside.sum()), steps + len(inside)
    if rows < 2:
        what = f"{'a single' if rows else 'no'} sample with a time"
        raise DataRefused(source.stated.name, None, what, "two at least", "name another", code=ErrorCode.TOO_SHORT)
    if head:
        pace = own_period(_rising(np.concatenate(head), source.stated))
    mean = total / steps if steps else pace
    found = mean if abs(mean / pace - 1) < MEAN_TOLERANCE else pace
    stated = source.stated.period
    if stated is not None and abs(found / stated - 1) > TOLERANCE:
        text = f"a sample rate of {1 / found:.6g} Hz by the times, {found / stated - 1:+.1%} of the period"
        raise DataRefused(
            source.stated.name, None, text, f"{1 / stated:.6g} Hz as stated, within 1 %", "correct one"
        )
    return Survey(rows, first, last, found)


def _rising(t: FloatArray, stated: Stated) -> FloatArray:
    found = np.unique(t)
    if len(found) < 2:
        raise DataRefused(stated.name, None, "a time that never changes", "times that rise", "state --rate HZ",
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


@dataclass(slots=True, eq=False)
class CheckedSamples:
    """The samples of a source; ``is_of_counts``: they must be whole numbers. Counts what it leaves out."""

    source: Source
    survey: Survey
    is_of_counts: bool
    lost: int = 0
    repeated: int = 0
    of_one_triad: int = 0
    sentinels: dict[float, int] = field(default_factory=dict)  # rows that hold a number which stands for no sample
    _rows: int = 0
    _last: FloatArray = field(default_factory=lambda: np.full(7, np.nan))
    _base: FloatArray | None = None

    def __iter__(self) -> Iterator[Samples]:
        """Yield what is left of each block.

        Raise `DataRefused` if rows share a time but not what was measured, or counts are no whole numbers.
        """
        for block in self.source.blocks():
            kept = self._usable(block)
            if len(kept.t):
                yield kept

    def _usable(self, block: Samples) -> Samples:
        marked = sentinel_cells(block.values)
        if marked.any():
            for number in np.unique(block.values[marked]).tolist():
                rows = (marked & (block.values == number)).any(axis=1)
                self.sentinels[number] = self.sentinels.get(number, 0) + int(rows.sum())
            block = replace(block, values=np.where(marked, np.nan, block.values))
        there: BoolArray = np.logical_not(np.isnan(block.values).all(axis=0))
        keep: BoolArray = np.logical_and(np.isfinite(block.t), finite_rows(block.values[:, there]))
        self.lost += int(np.sum(~keep & ~marked.any(axis=1)))
        self._refuse_other_rates(block, [finite_rows(block.values[:, part]) for part in (slice(3), slice(3, 6))])
        kept = self._once(_only(block, keep), block, keep)
        if self.is_of_counts and len(kept.t):
            self._refuse_fractions(block, keep, there)
        return self._increments(kept)

    def _refuse_other_rates(self, block: Samples, there: Sequence[BoolArray]) -> None:
        """Refuse rows of which many hold one triad alone: increments of the other rows would be lost."""
        self._rows += len(block.t)
        self.of_one_triad += int(np.sum(there[0] != there[1])) if all(part.any() for part in there) else 0
        if (share := self.of_one_triad / max(self._rows, 1)) > MAX_BRIDGED:
            slow = "accel" if there[0].sum() > there[1].sum() else "gyro"
            raise DataRefused(
                block.where, None, f"{share:.0%} of the rows with one triad alone", "both triads in each row",
                f"state --{slow} -,-,- to use the other triad alone, at its own rate", ErrorCode.COLUMNS,
            )  # fmt: skip

    def _once(self, kept: Samples, block: Samples, keep: BoolArray) -> Samples:
        """Return rows without those that were written twice."""
        if not len(kept.t):
            return kept
        last, self._last = self._last, np.append(kept.t[-1], kept.values[-1])
        shared = np.diff(kept.t, prepend=last[0]) == 0
        if not shared.any():
            return kept
        before = np.vstack((last[1:], kept.values[:-1]))
        same = shared & ((kept.values == before) | np.isnan(before)).all(axis=1)
        if (shared & ~same).any():
            at = int(np.flatnonzero(keep)[np.flatnonzero(shared & ~same)[0]])
            line = block.lines[at] if block.lines else None
            found, remedy = f"time {block.t[at]:.9g} again", "state --rate HZ if the stamps are those of reads"
            raise DataRefused(
                block.where, line, found, "a time of its own for each sample", remedy, code=ErrorCode.TIME_ORDER
            )
        self.repeated += int(same.sum())
        return _only(kept, ~same)

    def _refuse_fractions(self, block: Samples, keep: BoolArray, there: BoolArray) -> None:
        values = block.values[:, there]
        fractions = values != np.rint(values)
        if fractions.any() and (bad := keep & fractions.any(axis=1)).any():
            row = int(np.flatnonzero(bad)[0])
            number = next(v for v in values[row].tolist() if v != round(v))
            line = block.lines[row] if block.lines else None
            remedy = "name the columns of counts, or the calibration of this unit's rates"
            raise DataRefused(block.where, line, f"{number:.9g}", "whole counts, as the calibration", remedy)

    def _increments(self, block: Samples) -> Samples:
        """Return increments of running counts; the first row after a gap is their base, and no sample."""
        if self.source.stated.output != "cumulative" or not len(block.t):
            return block
        rows = np.column_stack((block.t, block.values))
        base, self._base = self._base, rows[-1]
        before = np.vstack((rows[:1] if base is None else base, rows[:-1]))
        step = rows - before
        if (bits := self.source.stated.wrap_bits) is not None:
            half = 2.0 ** (bits - 1)
            step[:, 1:] = (step[:, 1:] + half) % (2 * half) - half
        keep = (step[:, 0] > 0) & (step[:, 0] <= GAP_PERIODS * self.survey.period)
        return _only(replace(block, values=step[:, 1:]), keep)


def _only(block: Samples, keep: BoolArray) -> Samples:
    if keep.all():
        return block
    return replace(
        block, t=block.t[keep], values=block.values[keep],
        temperature=None if block.temperature is None else block.temperature[keep],
        auxiliary={name: values[keep] for name, values in block.auxiliary.items()},
    )  # fmt: skip
