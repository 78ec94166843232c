"""A table from elsewhere: columns by name or by number from 1, and what of it is no number."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from station.errors import DataRefused

MAX_NAMES_SHOWN = 30
_UNIT_IN_BRACKETS = re.compile(r"\s*[\[(].*[\])]\s*$")


@dataclass(frozen=True, slots=True, eq=False)
class LogTable:
    """A log's columns in their order, each (n,), nan where a cell is empty.

    ``lines`` (n,) are the rows' line numbers, None where a file has no lines. ``unreadable`` holds of a column its
    first cell that is no number: row and text. ``notes`` are what a reader had to assume;
    ``moments`` are columns of dates or clocks, in seconds since 1970 or since midnight. ``time_scale_s`` is how
    many seconds one unit of the time column is by the file's own header, None where that states no scale.
    ``damaged`` are rows that are nan where they are damaged, which ``notes`` say already.
    """

    file: Path
    columns: Mapping[str, FloatArray]
    sha256: str
    lines: "list[int] | None" = None
    unreadable: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    moments: frozenset[str] = frozenset()
    time_scale_s: float | None = None
    damaged: frozenset[int] = frozenset()

    @property
    def rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values())))

    def line(self, row: int) -> int | None:
        """Return the line of a row, None where a file has no lines."""
        return None if self.lines is None else self.lines[row]

    def name_of(self, key: str) -> str:
        """Return the name of the column that ``key`` names, or numbers from 1.

        Raises
        ------
        DataRefused
            If there is none or more than one.
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
        """Return a column (n,), in the log's own unit.

        Raises
        ------
        DataRefused
            If there is none, or a cell of it is no number: names the first.
        """
        name = self.name_of(key)
        if name in self.unreadable:
            row, text = self.unreadable[name]
            raise text_in_column(self.file, self.line(row), text, name)
        return self.columns[name]


def text_in_column(file: Path, line: int | None, text: str, name: str) -> DataRefused:
    """Return the refusal of a column of text that was asked for as numbers."""
    found = f"{text[:40]!a} in column {name}"
    return DataRefused(file, line, found, "a number or nothing", "name another column", ErrorCode.COLUMNS)
