"""A table of numbers: columns by name, each row's line for refusals; as a whole, or block by block.

A `Table` comes from `strict_csv` and from a recording, whose columns have names that this station knows, or from
`reader`, whose columns have whatever names a file gives them: `name_of` finds one.
"""

import lzma
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.errors import ErrorCode
from station.errors import DataRefused

HEAD_ROWS = 2000  # of which it is guessed what the columns hold
BLOCK_ROWS = 2**15
MAX_NAMES_SHOWN = 30
_UNIT_IN_BRACKETS = re.compile(r"\s*[\[(].*[\])]\s*$")
DAMAGE: tuple[type[Exception], ...] = (
    ValueError, TypeError, KeyError, IndexError, AttributeError, EOFError, MemoryError, OverflowError,
    RuntimeError, NotImplementedError, struct.error, zlib.error, lzma.LZMAError, zipfile.BadZipFile,
)  # fmt: skip
"""What libraries raise where an archive or a table of columns is damaged."""
DAMAGED_WITHIN: tuple[type[Exception], ...] = (*DAMAGE, OSError)  # once a file has been opened


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Columns in their order, each (n,) float64, nan where a cell is empty; counts below 2^53 are exact.

    ``lines`` (n,) are the rows' numbers of lines (text) or messages (MCAP) of the user's file, None where rows
    count from 1.
    ``unreadable`` holds of a column its first cell that is no number: row and text. ``notes`` are what a reader
    had to assume; ``moments`` are columns of dates or clocks, in seconds since 1970 or since midnight.
    ``time_scale_s`` is how many seconds one unit of the time column is by the file's own header, None where that
    states no scale. ``damaged`` are rows that are nan where they are damaged, which ``notes`` say already.
    ``text_of`` reads a cell, by line and column, as a text file writes it; None of a file without text.
    ``host_span`` is the station's own time [ns] of the first and last row where the file has it; ``damage`` says
    what is missing of a recording cut short.
    """

    file: Path
    columns: Mapping[str, FloatArray]
    sha256: str = ""
    lines: Sequence[int] | None = None
    unreadable: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    moments: frozenset[str] = frozenset()
    time_scale_s: float | None = None
    damaged: frozenset[int] = frozenset()
    host_span: tuple[int, int] | None = None
    damage: str | None = None
    text_of: Callable[[int, str], str] | None = None

    @property
    def name(self) -> str:
        """The file's name as it was given."""
        return str(self.file)

    @property
    def rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values())))

    def line(self, row: int) -> int:
        """Return the number of a row's line or message in its file, of the row itself where a file has neither."""
        return row + 1 if self.lines is None else self.lines[row]

    def rows_at(self, rows: IntArray) -> "Table":
        """Return a table of some rows, by their indices (m,), each still with its own line."""
        columns = {name: column[rows] for name, column in self.columns.items()}
        return replace(self, columns=columns, lines=[self.line(row) for row in rows.tolist()])

    def cell(self, row: int, name: str) -> str:
        """Return a cell of a column as its file writes it, for a message."""
        if self.text_of is not None:
            return self.text_of(self.line(row), name)
        value = float(self.columns[name][row])
        return f"{datetime.fromtimestamp(value, UTC):%F %T.%f}" if name in self.moments else f"{value:.12g}"

    def name_of(self, key: str) -> str:
        """Return the name of the column that ``key`` names, or numbers from 1.

        Raise `DataRefused` if there is none or more than one.
        """
        names = list(self.columns)
        bare = {name: _UNIT_IN_BRACKETS.sub("", name) for name in names}
        for alike in (
            [name for name in names if name == key],
            [name for name in names if bare[name] == key],
            [name for name in names if key.lower() in {name.lower(), bare[name].lower()}],
        ):
            if len(alike) == 1:
                return alike[0]
        if re.fullmatch(r"[0-9]{1,6}", key) and 1 <= int(key) <= len(names):
            return names[int(key) - 1]
        shown = ", ".join(names[:MAX_NAMES_SHOWN]) + (", ..." if len(names) > MAX_NAMES_SHOWN else "")
        expected = f"one of {shown}, or a number from 1 to {len(names)}"
        raise DataRefused(
            self.file, None, f"no column {key!a}", expected, "name another column", code=ErrorCode.COLUMNS
        )

    def column(self, key: str) -> FloatArray:
        """Return a column (n,), in the table's own unit.

        Raise `DataRefused` if there is none, or a cell of it is no number: names the first.
        """
        name = self.name_of(key)
        if name in self.unreadable:
            row, text = self.unreadable[name]
            raise text_in_column(self.file, self.line(row), text, name)
        return self.columns[name]


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Rows of a table: columns by name, each (n,), nan where a cell is empty.

    ``done`` is how much of the file has been read with them, 0 to 1. ``lines`` are their numbers, as of `Table`.
    """

    columns: Mapping[str, FloatArray]
    done: float
    lines: Sequence[int]


@dataclass(frozen=True, slots=True, eq=False)
class TableReader:
    """An open table: ``head`` are its first rows, with the names of all columns; ``read`` yields named columns.

    ``at_once`` reads the whole where that is another thing than all its blocks.
    """

    head: Table
    read: Callable[[Sequence[str]], Generator[Block]]
    at_once: Callable[[], Table] | None = None

    def whole(self) -> Table:
        """Return all rows of all columns."""
        if self.at_once is not None:
            return self.at_once()
        parts: dict[str, list[FloatArray]] = {name: [] for name in self.head.columns}
        for block in self.read(list(parts)):
            for name, column in block.columns.items():
                parts[name].append(column)
        columns = {name: np.concatenate(parts.pop(name)) for name in list(parts)}
        return replace(self.head, columns=columns)


def undamaged(blocks: Generator[Block], file: Path) -> Generator[Block]:
    """Yield blocks; raise `DataRefused` where one of them is damaged, or the disk refuses."""
    with closing(blocks):
        while True:
            try:
                block = next(blocks)
            except StopIteration:
                return
            except DataRefused:
                raise
            except DAMAGED_WITHIN as error:
                found = f"rows that cannot be read ({in_a_line(error)})"
                raise DataRefused(file, None, found, "an undamaged file") from None
            yield block


def text_in_column(file: Path, line: int | None, text: str, name: str) -> DataRefused:
    """Return the refusal of a column of text that was asked for as numbers."""
    found = f"{text[:40]!a} in column {name}"
    return DataRefused(file, line, found, "a number or nothing", "name another column", ErrorCode.COLUMNS)


def in_a_line(error: Exception) -> str:
    """Return what was raised in a few words."""
    lines = str(error).splitlines()
    return lines[0][:160] if lines and lines[0] else "cut short"


def seconds_of(values: "np.ndarray[tuple[int, ...], np.dtype[np.generic]]") -> FloatArray:
    """Return ``values`` (n, ...) as float64; dates and spans of time in s, dates since 1970, nan where empty."""
    if values.dtype.kind not in "mM":
        return values.astype(np.float64)
    whole = values.astype(f"{values.dtype.kind}8[ns]")
    return np.where(np.isnat(whole), np.nan, whole.astype(np.int64) / 1e9)
