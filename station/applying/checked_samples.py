"""Samples as they are applied: rows without a number left out, running counts made increments."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_times import GAP_PERIODS
from procedures.error_codes import ErrorCode
from station.applying.source import Samples, Source
from station.applying.survey import Survey
from station.errors import DataRefused


@dataclass(slots=True, eq=False)
class CheckedSamples:
    """The samples of a source; ``is_of_counts``: they must be whole numbers. Counts what it leaves out."""

    source: Source
    survey: Survey
    is_of_counts: bool
    lost: int = 0
    repeated: int = 0
    _last: FloatArray = field(default_factory=lambda: np.full(7, np.nan))
    _base: FloatArray | None = None

    def __iter__(self) -> Iterator[Samples]:
        """Yield what is left of each block.

        Raises
        ------
        DataRefused
            If rows share a time but not what was measured, or counts are no whole numbers.
        """
        for block in self.source.blocks():
            kept = self._usable(block)
            if len(kept.t):
                yield kept

    def _usable(self, block: Samples) -> Samples:
        there: BoolArray = np.logical_not(np.isnan(block.values).all(axis=0))
        keep: BoolArray = np.logical_and(np.isfinite(block.t), np.isfinite(block.values[:, there]).all(axis=1))
        self.lost += int(np.sum(~keep))
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
        if self.source.told.output != "cumulative" or not len(block.t):
            return block
        rows = np.column_stack((block.t, block.values))
        base, self._base = self._base, rows[-1]
        before = np.vstack((rows[:1] if base is None else base, rows[:-1]))
        step = rows - before
        if (bits := self.source.told.wrap_bits) is not None:
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
