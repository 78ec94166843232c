"""Samples checked before use: times rise at an even rate, no missing numbers, running counts made increments."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, finite_rows
from procedures.counts.missing_rows import MAX_BRIDGED
from procedures.counts.sample_times import GAP_PERIODS, own_period
from procedures.counts.sentinels import Sentinels
from procedures.errors import ErrorCode
from station.applying.source import Samples, Source, Stated
from station.errors import DataRefused

RATE_SAMPLES = 200_000  # from which the sample period is estimated first
MEAN_TOLERANCE = 1e-3  # relative, of the mean step against that: beyond it stamps are no times of samples
TOLERANCE = 0.01  # relative, of the period that a source states


@dataclass(frozen=True, slots=True)
class Survey:
    """How many samples there are at most, from when to when [s], and the period [s] of one.

    ``there`` marks of each file the columns (6,) that hold a number at all.
    """

    rows: int
    first: float
    last: float
    period: float
    sentinels: Sentinels
    there: Mapping[str, BoolArray]


@dataclass(slots=True)
class _Outputs:
    """What the outputs of one file hold."""

    there: BoolArray
    rows: int = 0
    of_one_triad: dict[str, int] = field(default_factory=lambda: {"gyro": 0, "accel": 0})

    def add(self, values: FloatArray) -> None:
        self.there = self.there | ~np.isnan(values).all(axis=0)
        self.rows += len(values)
        gyro, accel = finite_rows(values[:, :3]), finite_rows(values[:, 3:])
        self.of_one_triad["gyro"] += int(np.sum(gyro & ~accel))
        self.of_one_triad["accel"] += int(np.sum(accel & ~gyro))

    def refuse_other_rates(self, where: str) -> None:
        """Refuse a file of which many rows hold one triad alone: increments of the other rows would be lost."""
        share = sum(self.of_one_triad.values()) / max(self.rows, 1)
        if share > MAX_BRIDGED and self.there[:3].any() and self.there[3:].any():
            slow = min(self.of_one_triad, key=self.of_one_triad.__getitem__)
            raise DataRefused(
                where, None, f"{share:.0%} of the rows with one triad alone", "both triads in each row",
                f"state --{slow} -,-,- to use the other triad alone, at its own rate", ErrorCode.COLUMNS,
            )  # fmt: skip


def survey(source: Source) -> Survey:
    """Look at all samples of a source.

    Raise `DataRefused` if time goes back, never moves, or is more than 1 % off the pace that the source states, or
    many rows of a file hold one triad alone.
    """
    rows, first, last = 0, np.nan, -np.inf
    head, pace, total, steps = list[FloatArray](), 0.0, 0.0, 0
    sentinels, outputs = Sentinels(6), dict[str, _Outputs]()
    for block in source.blocks():
        sentinels.add(block.values)
        outputs.setdefault(block.where, _Outputs(np.zeros(6, dtype=np.bool_))).add(block.values)
        t = block.t[np.isfinite(block.t)]
        if not len(t):
            continue
        step = np.diff(t, prepend=last)
        if (back := np.flatnonzero(step < 0)).size:
            raise _goes_back(block, t, int(back[0]), last)
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
    for where, each in outputs.items():
        each.refuse_other_rates(where)
    return Survey(rows, first, last, found, sentinels, {where: each.there for where, each in outputs.items()})


def _rising(t: FloatArray, stated: Stated) -> FloatArray:
    found = np.unique(t)
    if len(found) < 2:
        raise DataRefused(stated.name, None, "a time that never changes", "times that rise", "state --rate HZ",
                          ErrorCode.TIME_ORDER)  # fmt: skip
    return found


def _goes_back(block: Samples, t: FloatArray, at: int, last: float) -> DataRefused:
    row = int(np.flatnonzero(np.isfinite(block.t))[at])
    before = t[at - 1] if at else last
    expected = "times that rise from row to row"
    place = block.lines[row] if block.lines else None
    return DataRefused(
        block.where,
        place,
        f"time {t[at]:.9g} after {before:.9g}",
        expected,
        "cut it in two there",
        ErrorCode.TIME_ORDER,
    )


@dataclass(slots=True, eq=False)
class CheckedSamples:
    """The samples of a source; ``is_of_counts``: they must be whole numbers. Counts what it leaves out."""

    source: Source
    survey: Survey
    is_of_counts: bool
    lost: int = 0
    repeated: int = 0
    sentinels: dict[float, int] = field(default_factory=dict)  # rows that hold a number which stands for no sample
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
        marked = self.survey.sentinels.cells(block.values)
        if marked.any():
            for number in np.unique(block.values[marked]).tolist():
                rows = (marked & (block.values == number)).any(axis=1)
                self.sentinels[number] = self.sentinels.get(number, 0) + int(rows.sum())
            block = replace(block, values=np.where(marked, np.nan, block.values))
        there = self.survey.there[block.where]
        keep: BoolArray = np.logical_and(np.isfinite(block.t), finite_rows(block.values[:, there]))
        self.lost += int(np.sum(~keep & ~marked.any(axis=1)))
        kept = self._once(_only(block, keep), block, keep)
        if self.is_of_counts and len(kept.t):
            self._refuse_fractions(block, keep, there)
        return self._increments(kept)

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
