"""Text with a row a line: any delimiter, with or without a header, with lines above it that are neither."""

import hashlib
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from drivers.text_decoding import decoded_text
from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.logs.log_table import LogTable
from station.files.logs.text_header import COMMENT, column_names
from station.files.logs.text_moments import moment

MAX_FILE = 2**29  # bytes: eight times as much memory while it is read and diagnosed
OF_NUMBERS = frozenset("0123456789+-.")  # a row that begins so is no comment
LOOKED_AT = 200  # lines in which the table must begin
SAME_LINES = 6  # lines of one shape that make a table
DELIMITERS = (",", ";", "\t", "|", None)  # None: blanks
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?|[+-]?(?:nan|inf)", re.IGNORECASE)
_MISSING = frozenset({"", "-", "--", "?", "na", "n/a", "#n/a", "null", "none", "missing"})
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+(?:[eE][+-]?[0-9]+)?")


@dataclass(frozen=True, slots=True)
class Layout:
    """How rows of a text are parted, the first of them, their names; ``numbers`` less text in the first rows.

    ``moments`` are the columns that hold dates or clocks (`text_moments`).
    """

    delimiter: str | None
    first: int
    names: tuple[str, ...]
    has_decimal_comma: bool
    numbers: int
    moments: tuple[int, ...]


def read_text_log(file: Path) -> LogTable:
    """Read a text log; raise `DataRefused` where it holds no table or a row has another number of cells."""
    if file.stat().st_size > MAX_FILE:
        raise DataRefused(
            file, None, f"{file.stat().st_size} bytes", f"at most {MAX_FILE}", "save it as .npz, or cut it"
        )
    content = file.read_bytes()
    text = decoded(content, file)
    lines = text.splitlines()
    layout = layout_of(lines[:LOOKED_AT], file)
    kept = [i for i in range(layout.first, len(lines)) if lines[i][:1] in OF_NUMBERS or is_row(lines[i])]
    rows = [lines[i] for i in kept]
    notes = list[str]()
    if layout.has_decimal_comma:
        rows = [row.replace(",", ".") for row in rows]
        notes.append("decimal commas")
    if not has_all_cells(rows[-1], layout):
        notes.append(f"line {kept[-1] + 1}, the last, is cut short and left out")
        rows, kept = rows[:-1], kept[:-1]
    values, unreadable = values_of(rows, kept, layout, file)
    columns = {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(layout.names)}
    sha256 = hashlib.sha256(content).hexdigest()
    moments = frozenset(layout.names[i] for i in layout.moments)
    return LogTable(file, columns, sha256, [i + 1 for i in kept], unreadable, tuple(notes), moments)


def decoded(content: bytes, file: Path) -> str:
    """Return a file's bytes as text; raise `DataRefused` where they are none."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", "replace")
    if b"\0" in content[:4096]:
        raise DataRefused(
            file, None, "binary data", "a table as text, .mat, .npz or .parquet",
            "write a short reader that saves it as .npz (docs/logs.md)",
        )  # fmt: skip
    return decoded_text(content)


def is_row(line: str) -> bool:
    """Say whether a line is neither empty nor a comment."""
    return bool(line.strip()) and not line.lstrip().startswith(COMMENT)


def has_all_cells(row: str, layout: Layout) -> bool:
    """Say whether a row has as many cells as the table has columns."""
    return len(_cells(row, layout.delimiter)) >= len(layout.names)


def _cells(line: str, delimiter: str | None) -> list[str]:
    return [cell.strip().strip('"') for cell in line.split(delimiter)]


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.fullmatch(cell))


def layout_of(lines: Sequence[str], file: Path) -> Layout:
    """Return the layout of lines with the most numbers, text counted against it; `DataRefused` of none."""
    found = [layout for each in DELIMITERS for layout in _layouts(lines, each)]
    if not found:
        raise DataRefused(file, None, "no table", "rows of numbers, two at least", "name another file")
    best = max(found, key=lambda each: (each.numbers, len(each.names)))
    above = [i for i in range(best.first) if is_row(lines[i])]
    if above and len(cells := _cells(lines[above[-1]], best.delimiter)) > 1 and all(map(_is_number, cells)):
        expected = f"{len(best.names)} as in line {best.first + 1}"
        raise DataRefused(file, above[-1] + 1, f"{len(cells)} cells", expected)
    return best


def _layouts(lines: Sequence[str], delimiter: str | None) -> Iterator[Layout]:
    """Yield the first stretch of rows of one shape, or that goes to the end; with decimal commas or without."""
    at = [i for i, line in enumerate(lines) if is_row(line)]
    split = [_cells(lines[i], delimiter) for i in at]
    for comma in (False, True) if delimiter != "," else (False,):
        numbers_of = cache(lambda i, comma=comma: sum(_is_cell(cell, comma) for cell in split[i]))
        for k, cells in enumerate(split):
            rows = split[k : k + SAME_LINES]
            if len(rows) < min(SAME_LINES, 2) or any(len(row) != len(cells) for row in rows):
                continue
            numbers = [numbers_of(i) for i in range(k, k + len(rows))]
            if min(numbers) > 0 and 2 * numbers[0] >= max(numbers):
                text = sum(bool(cell) for row in rows for cell in row) - sum(numbers)
                names = column_names(lines[: at[k]], lambda line: _cells(line, delimiter), _is_number, len(cells))
                moments = tuple(i for i in range(len(cells)) if all(moment(row[i]) is not None for row in rows))
                yield Layout(delimiter, at[k], names, comma, sum(numbers) - text, moments)
                break


def _is_cell(cell: str, comma: bool) -> bool:
    return _is_number(cell) or moment(cell) is not None or (comma and bool(_DECIMAL_COMMA.fullmatch(cell)))


def values_of(
    rows: Sequence[str], kept: Sequence[int], layout: Layout, file: Path
) -> tuple[FloatArray, dict[str, tuple[int, str]]]:
    """Return the cells as numbers (n, columns), all at once, or one by one where not all of them are.

    With them of each column the first cell that is no number: row and text. ``kept`` are the rows' lines from 0.
    """
    try:
        seconds: dict[int | str, Callable[[str], float]] = dict.fromkeys(layout.moments, _moment)
        values = np.loadtxt(rows, delimiter=layout.delimiter, comments=None, ndmin=2, converters=seconds or None)
    except ValueError:
        return _one_by_one(rows, kept, layout, file)
    if values.shape[1] != len(layout.names):
        return _one_by_one(rows, kept, layout, file)
    return values, {}


def _moment(cell: str) -> float:
    if (seconds := moment(cell.strip())) is None:
        raise ValueError(cell)
    return seconds


def _one_by_one(
    rows: Sequence[str], kept: Sequence[int], layout: Layout, file: Path
) -> tuple[FloatArray, dict[str, tuple[int, str]]]:
    values = np.full((len(rows), len(layout.names)), np.nan)
    unreadable = dict[str, tuple[int, str]]()
    for i, row in enumerate(rows):
        cells = _cells(row, layout.delimiter)
        if len(cells) != len(layout.names):
            expected = f"{len(layout.names)} as in line {kept[0] + 1}"
            raise DataRefused(file, kept[i] + 1, f"{len(cells)} cells", expected)
        for j, cell in enumerate(cells):
            if _is_number(cell):
                values[i, j] = float(cell.lower().replace("d", "e"))
            elif j in layout.moments and (seconds := moment(cell)) is not None:
                values[i, j] = seconds
            elif cell.lower() not in _MISSING:
                unreadable.setdefault(layout.names[j], (i, cell))
    return values, unreadable
