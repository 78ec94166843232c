"""Rows of a text log as numbers, and which of them are damaged: single ones are lost, many are no log.

A serial line or a card that loses bytes cuts lines, runs two together and garbles cells. Such a row has another
number of cells, a cell that is no number in a column of numbers, or one with other decimals in a column that
always prints as many; what is damaged becomes nan. A column in which text is common is one of text instead.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import FloatArray, IntArray
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.dates import DateOrder, moment
from station.files.tables.text_layout import MISSING, Layout

MAX_DAMAGED = 0.01  # of the rows: more is no line that lost a few bytes
MAX_KEPT = 100_000  # cells of a column: a column of text is one from the first on
ROWS_AT_ONCE = 500  # that are read together where not all can be

_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")


@dataclass(slots=True)
class Cells:
    """How many cells of a column are wrong; ``kept`` holds them by row, the first `MAX_KEPT`."""

    count: int = 0
    kept: dict[int, str] = field(default_factory=dict)

    def add(self, row: int, cell: str) -> None:
        """Count a cell."""
        self.count += 1
        if self.count <= MAX_KEPT:
            self.kept[row] = cell


@dataclass(slots=True)
class Damage:
    """What is damaged among ``rows``, by row: ``cut`` of another number of cells, and cells by column.

    ``text`` are cells that are no number, ``misprinted`` those of other decimals than all others in their column.
    """

    rows: int = 0
    cut: dict[int, str] = field(default_factory=dict)
    text: dict[int, Cells] = field(default_factory=dict)
    misprinted: dict[int, Cells] = field(default_factory=dict)

    def add(self, other: "Damage") -> None:
        """Take in what is damaged in the rows that follow."""
        for mine, its in ((self.text, other.text), (self.misprinted, other.misprinted)):
            for column, cells in its.items():
                own = mine.setdefault(column, Cells())
                for row, cell in cells.kept.items():
                    own.add(self.rows + row, cell)
                own.count += cells.count - len(cells.kept)
        self.cut |= {self.rows + row: text for row, text in other.cut.items()}
        self.rows += other.rows

    def is_rare(self, count: int) -> bool:
        """Return whether so many rows may be damaged in what still is a log."""
        return count <= MAX_DAMAGED * self.rows

    @property
    def places(self) -> set[int]:
        """The rows in which anything is wrong."""
        columns = (*self.text.values(), *self.misprinted.values())
        return set(self.cut).union(*(cells.kept for cells in columns))

    def unreadable(self, names: Sequence[str]) -> dict[str, tuple[int, str]]:
        """Return the columns in which text is common, of all ``names``, each with its first: row and cell."""
        common = {i: cells for i, cells in self.text.items() if not self.is_rare(cells.count)}
        return {names[i]: next(iter(cells.kept.items())) for i, cells in common.items()}

    def without_misprints(self, values: FloatArray) -> FloatArray:
        """Return the rows' numbers ``values`` (n, columns), nan where other decimals than usual are rare."""
        for i, cells in self.misprinted.items():
            if self.is_rare(cells.count):
                values[list(cells.kept), i] = np.nan
        return values

    def descriptions(self, layout: Layout) -> dict[int, str]:
        """Return the rows that are damaged in what is not text, each with what is wrong with it."""
        found = dict[int, str]()
        for by_column in (self.misprinted, self.text):
            for i, cells in by_column.items():
                if self.is_rare(cells.count):
                    found |= {
                        row: f"{cell[:40]!a} in column {layout.names[i]}" for row, cell in cells.kept.items()
                    }
        return found | self.cut

    def note(self, layout: Layout, line_of: Callable[[int], int], file: Path) -> tuple[str, ...]:
        """Return in words what is lost; ``line_of`` gives a row's line.

        Raise `DataRefused` if more than `MAX_DAMAGED` of the rows are damaged: names the first.
        """
        if not (found := self.descriptions(layout)):
            return ()
        first = min(found)
        if not self.is_rare(len(found)):
            raise DataRefused(
                file, line_of(first), f"{len(found)} of {self.rows} rows damaged, the first here: {found[first]}",
                f"{MAX_DAMAGED:.0%} at most", "record it again, or remove lines that are no rows of this table",
                ErrorCode.DAMAGED_ROWS,
            )  # fmt: skip
        count = "1 row is" if len(found) == 1 else f"{len(found)} rows are"
        return (f"{count} damaged and lost, first line {line_of(first)}: {found[first]}",)


def values_of(rows: Sequence[str], layout: Layout) -> tuple[FloatArray, Damage]:
    """Return the cells as numbers (n, columns), nan where they are missing or no number, and the damage."""
    if (whole := _together(rows, layout)) is not None:
        return whole
    values, damage = np.empty((len(rows), len(layout.names))), Damage()
    for begin in range(0, len(rows), ROWS_AT_ONCE):
        part = rows[begin : begin + ROWS_AT_ONCE]
        read = _together(part, layout) if len(rows) > ROWS_AT_ONCE else None
        values[begin : begin + len(part)], own = read or _one_by_one(part, layout)
        damage.add(own)
    return values, damage


def _together(rows: Sequence[str], layout: Layout) -> tuple[FloatArray, Damage] | None:
    """Return rows as numbers all at once; None where one of them is none, or has another number of cells."""
    count, delimiter = len(layout.names), layout.delimiter
    text = "\n".join(rows)
    if layout.grouping or '"' in text:
        return None
    one_blank = text if delimiter else "\n".join(" ".join(row.split()) for row in rows)
    if (grid := _grid(one_blank, delimiter or " ", count)) is None:
        return None
    try:
        seconds: dict[int | str, Callable[[str], float]] = {
            i: partial(_moment, order=order) for i, order in layout.moments.items()
        }
        columns = None if delimiter is None else range(count)
        plain = text.replace(",", ".").split("\n") if layout.has_decimal_comma else rows
        values = np.loadtxt(
            plain, delimiter=delimiter, comments=None, ndmin=2, converters=seconds or None, usecols=columns
        )
    except ValueError:
        return None
    if values.shape != (len(rows), count):
        return None
    damage = Damage(len(rows))
    for i in _not_as_printed(*grid, layout).tolist():
        _find_misprints(i, layout.cells(rows[i]), layout, damage)
    return values, damage


def _grid(text: str, delimiter: str, count: int) -> tuple[NDArray[np.uint8], IntArray] | None:
    """Return a text's characters, one byte each, and where its cells (rows, count) end; None of uneven rows."""
    octets = np.frombuffer(f"{text}\n".encode("latin-1", "replace"), np.uint8)
    ends = np.flatnonzero((octets == ord(delimiter)) | (octets == ord("\n")))
    rows = text.count("\n") + 1
    for width in (count, count + 1):  # with a delimiter at the end
        if len(ends) != rows * width:
            continue
        grid = ends.reshape(rows, width)
        is_even = (octets[grid[:, -1]] == ord("\n")).all() and (octets[grid[:, :-1]] != ord("\n")).all()
        is_even = is_even and (width == count or not text[grid[0, -2] + 1 : grid[0, -1]].strip())
        return (octets, grid[:, :count]) if is_even else None
    return None


def _not_as_printed(octets: NDArray[np.uint8], ends: IntArray, layout: Layout) -> IntArray:
    """Return the rows in which the decimal mark of any cell is not where its column always prints it."""
    mark, as_printed = ord("," if layout.has_decimal_comma else "."), np.ones(len(ends), np.bool_)
    for i, decimals in enumerate(layout.decimals):
        if decimals is not None:
            as_printed &= octets[ends[:, i] - 1 - decimals] == mark
    found: IntArray = np.flatnonzero(~as_printed)
    return found


def _moment(cell: str, order: DateOrder | None) -> float:
    if (seconds := moment(cell.strip(), order)) is None:
        raise ValueError(cell)
    return seconds


def _one_by_one(rows: Sequence[str], layout: Layout) -> tuple[FloatArray, Damage]:
    values, damage = np.full((len(rows), len(layout.names)), np.nan), Damage(len(rows))
    for i, row in enumerate(rows):
        cells = layout.cells(row)
        if len(cells) != len(layout.names):
            damage.cut[i] = f"{len(cells)} cells instead of {len(layout.names)}"
            continue
        for j, cell in enumerate(cells):
            if (number := layout.number(cell)) is not None:
                values[i, j] = number
            elif j in layout.moments and (seconds := moment(cell, layout.moments[j])) is not None:
                values[i, j] = seconds
            elif cell.lower() not in MISSING:
                damage.text.setdefault(j, Cells()).add(i, cell)
        _find_misprints(i, cells, layout, damage)
    return values, damage


def _find_misprints(row: int, cells: Sequence[str], layout: Layout, damage: Damage) -> None:
    """Note the cells with other decimals than their column always prints: digits or a point were lost."""
    for i, usual in enumerate(layout.decimals):
        plain = layout.plain(cells[i])
        if usual is not None and _DECIMAL.fullmatch(plain) and len(plain.partition(".")[2]) != usual:
            damage.misprinted.setdefault(i, Cells()).add(row, cells[i])
