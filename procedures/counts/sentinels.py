"""Numbers that stand for no sample, as 9999 or -999: decided over a whole log, which may come in blocks."""

from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import BoolArray, FloatArray, true_runs

MIN_SENTINELS = 3  # cells of one number, far from all others
MAX_LOG_CHANCE = -14.0  # ln of how many such rows chance makes: once in a million recordings
SENTINEL_FAR = 10.0  # times the spread of all others: what moves passes through the values in between
LONGEST_RUN = 3  # rows in sequence, of most runs: what stays longer is a state of the sensor
COUNTED_LEVELS = 2**16  # of a channel: more of them change no decision, and all would need much memory


@dataclass(slots=True)
class _End:
    """The two largest numbers of a column, and the runs of rows that hold the largest."""

    top: float = -np.inf
    second: float = -np.inf
    cells: int = 0
    runs: int = 0
    long_runs: int = 0
    _open: int = 0  # rows of the run that the last block ended with

    def add(self, values: FloatArray) -> None:
        """Take in the next rows (n,), in any unit; what is not finite is no number."""
        known = values[np.isfinite(values)]
        top = float(np.max(known, initial=self.top))
        if top > self.top:
            self.second, self.top = self.top, top
            self.cells = self.runs = self.long_runs = self._open = 0
        self.second = float(np.max(known, where=known < top, initial=self.second))
        runs = true_runs(values == top)
        lengths = np.ptp(runs, axis=1)
        if self._open and len(runs) and runs[0, 0] == 0:  # it goes on from the block before
            self.runs, self.long_runs = self.runs - 1, self.long_runs - (self._open > LONGEST_RUN)
            lengths[0] += self._open
            self.cells -= self._open
        self.cells, self.runs = self.cells + int(lengths.sum()), self.runs + len(runs)
        self.long_runs += int(np.sum(lengths > LONGEST_RUN))
        if len(values):
            self._open = int(lengths[-1]) if len(runs) and runs[-1, 1] == len(values) else 0

    def is_far(self, least: float) -> bool:
        """Say whether the largest is far from all others, which begin at ``least``."""
        return self.second > least and self.top - self.second > SENTINEL_FAR * (self.second - least)


@dataclass(slots=True, eq=False)
class Sentinels:
    """The numbers that stand for no sample in the columns of a log, in any units.

    Either all columns that change hold it in one row, which is no chance; or it is the largest or smallest of its
    column, far from all others, comes in `MIN_SENTINELS` cells or more, and in short runs. What fills half of the
    rows is no sentinel.
    """

    columns: int
    _rows: int = 0
    _ends: dict[float, list[_End]] = field(init=False)  # by sign, of each column
    _levels: list[FloatArray] = field(init=False)
    _first: FloatArray = field(init=False)  # of each column
    _is_number: BoolArray = field(init=False)
    _changes: BoolArray = field(init=False)
    _alike: int = 0  # rows in which all columns that change hold one number
    _alike_first: FloatArray = field(init=False)  # of them, those that hold the first number of each column

    def __post_init__(self) -> None:
        """Begin without rows."""
        self._ends = {sign: [_End() for _ in range(self.columns)] for sign in (1.0, -1.0)}
        self._levels = [np.empty(0) for _ in range(self.columns)]
        self._first, self._alike_first = np.full(self.columns, np.nan), np.zeros(self.columns)
        self._is_number, self._changes = np.zeros((2, self.columns), dtype=np.bool_)

    def add(self, values: FloatArray) -> None:
        """Take in the next rows ``values`` (n, k), in any units."""
        if not len(values):
            return
        self._first = self._first if self._rows else values[0]
        self._rows += len(values)
        for sign, ends in self._ends.items():
            for end, column in zip(ends, values.T, strict=True):
                end.add(sign * column)
        for i, known in enumerate(self._levels):
            if len(known) < COUNTED_LEVELS:
                self._levels[i] = np.union1d(known, values[:, i])
        self._count_alike(values)

    def _count_alike(self, values: FloatArray) -> None:
        self._is_number |= np.isfinite(values).any(axis=0)
        begins = self._is_number & (values != self._first).any(axis=0) & ~self._changes
        if begins.any():  # these were constant until here: of the rows before, those that hold the same stay alike
            constants = self._first[begins]
            same: BoolArray = self._first == (constants[0] if (constants == constants[0]).all() else np.nan)
            self._alike_first[~same] = 0
            self._alike, self._changes = int(self._alike_first.max()), self._changes | begins
        changing = values[:, self._changes]
        self._alike += int((changing == changing[:, :1]).all(axis=1).sum())
        for i, first in enumerate(self._first):
            self._alike_first[i] += np.sum((changing == first).all(axis=1) & (values[:, i] == first))

    def cells(self, values: FloatArray) -> BoolArray:
        """Mark cells of ``values`` (n, k) that hold a sentinel by all rows that were added."""
        marked = np.zeros(values.shape, dtype=np.bool_)
        if self._is_alike_sentinel():
            changing = values[:, self._changes]
            marked[np.ix_((changing == changing[:, :1]).all(axis=1), self._changes)] = True
        for sign, ends in self._ends.items():
            others = self._ends[-sign]
            far = {i: end for i, end in enumerate(ends) if end.is_far(-others[i].top)}
            for i, end in far.items():
                alike = sum(each.cells for each in far.values() if each.top == end.top)
                if alike >= MIN_SENTINELS and 2 * end.long_runs < end.runs and 2 * end.cells < self._rows:
                    marked[:, i] |= values[:, i] == sign * end.top
        return marked

    def _is_alike_sentinel(self) -> bool:
        if (k := int(self._changes.sum())) < 2 or not 0 < 2 * self._alike < self._rows:
            return False
        levels = min(len(self._levels[i]) for i in np.flatnonzero(self._changes).tolist())
        return bool(np.log(self._rows) - (k - 1) * np.log(levels) < MAX_LOG_CHANCE)


def sentinel_cells(values: FloatArray) -> BoolArray:
    """Mark cells of a whole log's ``values`` (n, k), in any units, that hold one of its `Sentinels`."""
    found = Sentinels(values.shape[1])
    found.add(values)
    return found.cells(values)
