"""A CSV file of this station's own columns: fast where every cell is right, exact about the first that is not.

A block of whole lines is matched against the grammar of a row as one regular expression and then converted at
once; only a block that does not match is looked at line by line.
"""

import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.missing_rows import INTERPOLATED
from station.errors import DataRefused
from station.files.opening import MAX_LINE
from station.files.tables.table import Table

TRIADS = {"gyro": ("gx", "gy", "gz"), "accel": ("ax", "ay", "az")}
OUTPUTS = TRIADS["gyro"] + TRIADS["accel"]
MAX_EXACT_INTEGER = 2**53  # integers below it are exact in float64


_AUX = re.compile(r"aux_[A-Za-z0-9_]+")
_SAMPLE_COLUMNS = ("t_s", *OUTPUTS, "temp_c", "utc_s", INTERPOLATED, "aux_NAME")
RATE_TABLE_COLUMNS = ("rate_ref_deg_s", "t_s", *TRIADS["gyro"], "temp_c")


@dataclass(frozen=True, slots=True)
class NamedColumns:
    """What a file's header must hold, and what it may hold besides, whose cells may be empty.

    Of each group of columns ``together`` all are there or none.
    """

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()
    together: tuple[tuple[str, ...], ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that may be there."""
        return (*self.needed, *self.optional)

    def cell(self, name: str) -> str:
        """Return what a cell of a column holds, as text."""
        return "a number" if name in self.needed else "a number or nothing"

    def check(self, names: list[str], file: Path) -> None:
        """Refuse a file that lacks a column, or has only a part of a group."""
        for name in self.needed:
            if name not in names:
                raise DataRefused(file, 1, f"no column {name}", f"the columns {','.join(self.needed)}")
        _refuse_part(self.together, names, file)


@dataclass(frozen=True, slots=True)
class SampleColumns:
    """What a data file holds: a row per sample, or a row per point of a turntable; counts or reals."""

    counts: bool
    rate_table: bool = False

    @property
    def time(self) -> str:
        """The column that must be there."""
        return "rate_ref_deg_s" if self.rate_table else "t_s"

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that may be there."""
        return RATE_TABLE_COLUMNS if self.rate_table else _SAMPLE_COLUMNS

    def cell(self, name: str) -> str:
        """Return what a cell of a column holds, as text."""
        if name in {self.time, "t_s"}:
            return "a number"
        if name in OUTPUTS:
            return "an integer" if self.counts and not self.rate_table else "a number"
        return "a number or nothing"

    def check(self, names: list[str], file: Path) -> None:
        """Refuse a file that lacks its time or reference column, or has no triad or only a part of one."""
        if self.time not in names:
            raise DataRefused(file, 1, f"no column {self.time}", f"a column {self.time}")
        if not self.rate_table:
            _refuse_part(TRIADS.values(), names, file)
        if not any(name in names for name in OUTPUTS):
            raise DataRefused(file, 1, "no output column", "gx,gy,gz or ax,ay,az")


def _refuse_part(groups: Iterable[tuple[str, ...]], names: list[str], file: Path) -> None:
    for group in groups:
        there = [name for name in group if name in names]
        if there and len(there) < len(group):
            raise DataRefused(file, 1, f"only {','.join(there)}", f"all of {','.join(group)} or none")


def read_header(header: bytes, file: Path, kind: NamedColumns | SampleColumns) -> dict[str, str]:
    """Return the columns of a header line in their order, each with what its cells hold.

    Raise `DataRefused` if a column is unknown, missing or double.
    """
    expected = f"columns out of {','.join(kind.columns)}"
    if header.startswith(b"\xef\xbb\xbf"):
        raise DataRefused(file, 1, "a byte order mark", "plain UTF-8 that begins with the header")
    if not header.strip():
        raise DataRefused(file, 1, "no header", expected)
    names = header.removesuffix(b"\r").decode("utf-8", "backslashreplace").split(",")
    for index, name in enumerate(names):
        known = name in kind.columns and name != "aux_NAME"
        if not known and not ("aux_NAME" in kind.columns and _AUX.fullmatch(name)):
            raise DataRefused(file, 1, f"column {name[:40]!a}", expected)
        if name in names[:index]:
            raise DataRefused(file, 1, f"column {name} twice", "each column once")
    kind.check(names, file)
    return {name: kind.cell(name) for name in names}


_BLOCK = 2**22
_REAL = rb"[+-]?+(?:[0-9]++(?:\.[0-9]*+)?+|\.[0-9]++)(?:[eE][+-]?+[0-9]++)?+"
NOTHING = "nothing, as in the first row"
_ABSENT = "; 0, or nothing in every row, for a channel that the device does not have"
_CELL = {  # what a cell may hold, as a pattern
    "an integer": re.compile(rb"[+-]?+[0-9]++"),
    "a number": re.compile(_REAL),
    "a number or nothing": re.compile(rb"(?:" + _REAL + rb")?+"),
    NOTHING: re.compile(rb""),
}


class _Numbers(dict[bytes, float]):
    """Remembers what a cell means: counts are few, and looking one up is half the work of reading it."""

    def __missing__(self, cell: bytes) -> float:
        number = float(cell or b"nan")
        if len(self) < 2**16:
            self[cell] = number
        return number


def read_csv(stream: BinaryIO, file: Path, kind: NamedColumns | SampleColumns) -> Table:
    """Read a step's CSV file.

    Raises
    ------
    DataRefused
        At the first header, line or cell that breaks a rule.
    """
    digest = hashlib.sha256()
    lines = _whole_lines(stream, file, digest)
    first = next(lines, b"")
    header, _, block = first.partition(b"\n")
    cells = read_header(header, file, kind)
    if isinstance(kind, SampleColumns):
        cells = _with_absent(cells, block.partition(b"\n")[0])
    row = re.compile(b"(?:" + b",".join(_CELL[c].pattern for c in cells.values()) + rb"\r?+\n)*+")
    numbers = _Numbers()
    parts = [_rows(block, file, 2, cells, row, numbers)]
    line = 2 + len(parts[0])
    for block in lines:
        parts.append(_rows(block, file, line, cells, row, numbers))
        line += len(parts[-1])
    values = np.concatenate(parts)
    if not len(values):
        raise DataRefused(file, 2, "no row", "at least one row after the header")
    _check_range(values, file, cells)
    columns = {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(cells)}
    if NOTHING in cells.values():
        columns = _without_absent(columns, cells, file)
    return Table(file, columns, digest.hexdigest(), range(2, 2 + len(values)))


def _with_absent(cells: dict[str, str], row: bytes) -> dict[str, str]:
    """Return what the cells hold, given the first row: an output that is empty there is empty in every row."""
    first = row.removesuffix(b"\r").split(b",")
    if len(first) != len(cells):
        return cells
    pairs = zip(cells.items(), first, strict=True)
    return {name: NOTHING if name in OUTPUTS and not cell else wanted for (name, wanted), cell in pairs}


def _without_absent(columns: dict[str, FloatArray], cells: dict[str, str], file: Path) -> dict[str, FloatArray]:
    """Return the columns without empty ones; of a triad that has another channel, 0 stands for an empty one."""
    absent = {name for name, wanted in cells.items() if wanted == NOTHING}
    there = {triad for triad in TRIADS for name in TRIADS[triad] if name in columns and name not in absent}
    if not there:
        raise DataRefused(file, 2, "every output empty", "counts or rates of one channel at least")
    if "rate_ref_deg_s" in columns:  # a rate table names the outputs that it has
        return {name: column for name, column in columns.items() if name not in absent}
    lost = {name for triad in TRIADS if triad not in there for name in TRIADS[triad]}
    return {
        name: np.zeros(len(column)) if name in absent else column
        for name, column in columns.items()
        if name not in lost
    }


def _whole_lines(stream: BinaryIO, file: Path, digest: "hashlib._Hash") -> Iterator[bytes]:
    """Yield blocks that end at the end of a line; the last line is given its newline if it lacks one."""
    rest, line = b"", 1
    while chunk := stream.read(_BLOCK):
        digest.update(chunk)
        end = chunk.rfind(b"\n") + 1
        block, rest = (rest + chunk[:end], chunk[end:]) if end else (b"", rest + chunk)
        _refuse_long_line(block, rest, file, line)
        line += block.count(b"\n")
        if block:
            yield block
    if rest:
        yield rest + b"\n"


def _refuse_long_line(block: bytes, rest: bytes, file: Path, line: int) -> None:
    starts = np.flatnonzero(np.frombuffer(block, np.uint8) == 0x0A) + 1
    lengths = np.diff(starts, prepend=0, append=len(block) + len(rest))
    if lengths.max() > MAX_LINE:
        first = int(np.argmax(lengths > MAX_LINE))
        raise DataRefused(file, line + first, "a line over 1 MiB", "lines of at most 1 MiB")


def _rows(
    block: bytes, file: Path, line: int, cells: dict[str, str], row: re.Pattern[bytes], numbers: _Numbers
) -> FloatArray:
    if not row.fullmatch(block):
        _refuse_first_bad_cell(block, file, line, cells)
    flat = block.replace(b"\r", b"").replace(b"\n", b",")
    if block and b",," not in flat and not flat.startswith(b","):
        values = np.fromstring(flat[:-1], sep=",")  # it knows no empty cell
    else:
        values = np.array(list(map(numbers.__getitem__, flat.split(b",")[:-1])), dtype=np.float64)
    return values.reshape(-1, len(cells))


def _refuse_first_bad_cell(block: bytes, file: Path, line: int, cells: dict[str, str]) -> None:
    for offset, text in enumerate(block[:-1].split(b"\n")):
        found = text.removesuffix(b"\r").split(b",")
        if len(found) != len(cells):
            what = f"{len(found)} cells" if text.strip() else "an empty line"
            raise DataRefused(file, line + offset, what, f"{len(cells)} cells: {','.join(cells)}")
        for cell, (name, wanted) in zip(found, cells.items(), strict=True):
            if not _CELL[wanted].fullmatch(cell):
                absent = _ABSENT if not cell and name in OUTPUTS else ""
                raise DataRefused(file, line + offset, f"{show(cell)} in column {name}", f"{wanted}{absent}")
    raise AssertionError("the grammar of a row and of its cells disagree")


def _check_range(values: FloatArray, file: Path, cells: dict[str, str]) -> None:
    """Refuse what does not fit the number type: counts not exact in float64, reals that overflow it."""
    limit = np.array(
        [MAX_EXACT_INTEGER if wanted == "an integer" else np.finfo(float).max for wanted in cells.values()]
    )
    bad = np.argwhere(np.abs(values) >= limit)
    if len(bad):
        row, column = bad[0]
        name, wanted = list(cells.items())[column]
        size = "2^53" if wanted == "an integer" else "1.8e308"
        raise DataRefused(file, 2 + int(row), f"a value too large in column {name}", f"{wanted} below {size}")


def show(cell: bytes) -> str:
    """Return a cell as it is shown to people: quoted, escaped and not too long."""
    text = cell.decode("utf-8", "backslashreplace")
    return ascii(text) if len(text) <= 40 else f"{text[:40]!a}... ({len(cell)} bytes)"
