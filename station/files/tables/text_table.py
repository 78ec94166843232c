"""Text with a row a line: any delimiter, with or without a header, with lines above it that are neither.

The form is that of the first lines, and every row must have it. A header may state scales: ``tscale,0.001`` above
the table of a .gcsv (docs.gyroflow.xyz, "Gyroflow IMU log": t times tscale is s, gx times gscale rad/s, ax times
ascale g).
"""

import re
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from drivers.text_decoding import decoded_text
from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.table import HEAD_ROWS, Block, Table, TableReader, in_blocks, text_in_column
from station.files.tables.text_layout import LOOKED_AT, Layout, is_number, is_row, layout_of
from station.files.tables.text_rows import Damage, values_of
from station.text import plural

READ_BYTES = 2**21
MAX_LINE = 2**20  # bytes
MAX_FILE = 2**29  # bytes: eight times as much memory while it is read and diagnosed
OF_NUMBERS = frozenset("0123456789+-.")  # a row that begins so is no comment
MAX_CONTROL = 0.05  # of bytes of text that are none of it: NULs of a card that lost power, bytes of a bad line
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_STATED = re.compile(r"\s*(tscale|gscale|ascale|orientation)\s*[,;\t=:]\s*(\S+?)\s*[,;]*\s*", re.IGNORECASE)
_SCALED = {"gscale": (re.compile(r"[gr][xyz]", re.IGNORECASE), "rad/s"),
           "ascale": (re.compile(r"a[xyz]", re.IGNORECASE), "g")}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class StatedScales:
    """Names and factors (columns,) of a table's columns by its header, and seconds of a unit of its time."""

    names: tuple[str, ...]
    factors: FloatArray
    time_s: float | None = None
    notes: tuple[str, ...] = ()


def stated_scales(above: Sequence[str], names: tuple[str, ...]) -> StatedScales:
    """Return what the lines above a table state of its columns ``names``."""
    found = {match[1].lower(): match[2] for line in above if (match := _STATED.fullmatch(line))}
    scales = {key: number for key in ("tscale", *_SCALED) if (number := _positive(found.get(key, "")))}
    factors, named, notes = np.ones(len(names)), list(names), list[str]()
    for key, (columns, unit) in _SCALED.items():
        its = [i for i, name in enumerate(names) if columns.fullmatch(name)]
        if key in scales and its:
            factors[its] = scales[key]
            for i in its:
                named[i] = f"{names[i]} [{unit}]"
            notes.append(
                f"{', '.join(names[i] for i in its)} times {key} {scales[key]:g} of the header are {unit}"
            )
    orientation = found.get("orientation", "")
    if orientation and orientation != "XYZ":
        notes.append(f"orientation {orientation} of the header is not applied: axes are those of the columns")
    return StatedScales(tuple(named), factors, scales.get("tscale"), tuple(notes))


def _positive(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if np.isfinite(number) and number > 0 else None


@dataclass(frozen=True, slots=True)
class TextForm:
    """How a text is read: the layout of its rows, and the scales that the lines above its table state."""

    layout: Layout
    scales: StatedScales

    @classmethod
    def of(cls, lines: Sequence[str], file: Path) -> "TextForm":
        """Return the form of a text by its first lines; raise `DataRefused` of no table."""
        layout = layout_of(lines[:LOOKED_AT], file)
        return cls(layout, stated_scales(lines[: layout.first], layout.names))

    def table(self, file: Path, lines: Sequence[str], before: int, *, is_last: bool) -> "Part":
        """Return rows of the text, ``before`` lines after its first, as a table with their damage."""
        layout, notes = self.layout, list[str]()
        first = max(layout.first - before, 0)
        kept = [i for i in range(first, len(lines)) if lines[i][:1] in OF_NUMBERS or is_row(lines[i].strip("\0"))]
        again = {i for i in kept if lines[i][:1] not in OF_NUMBERS and self._is_header(lines[i])}
        kept = [i for i in kept if i not in again]
        notes += [f"the header is repeated {plural(len(again), 'time')}"] if again else []
        ends = [("first", 0)] if not before and kept and kept[0] == 0 else []
        ends += [("last", -1)] if is_last else []
        for which, end in ends:
            if len(kept) > 2 and len(layout.cells(lines[kept[end]])) < len(layout.names):
                notes.append(f"line {kept[end] + 1 + before}, the {which}, is incomplete and not used")
                del kept[end]
        rows = [lines[i].strip("\0") if "\0" in lines[i] else lines[i] for i in kept]
        values, damage = values_of(rows, layout) if rows else (np.empty((0, len(layout.names))), Damage())
        values *= self.scales.factors
        numbers = [before + i + 1 for i in kept]
        columns = {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(self.scales.names)}
        moments = frozenset(self.scales.names[i] for i in layout.moments)
        table = Table(
            file, columns, lines=numbers, notes=tuple(notes), moments=moments, time_scale_s=self.scales.time_s
        )
        return Part(table, damage)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed of the form."""
        layout, text = self.layout, list[str]()
        if layout.has_decimal_comma:
            text.append("decimal commas")
        if layout.grouping:
            text.append(f"thousands parted by {layout.grouping!r}")
        return (*layout.notes, *text, *self.scales.notes)

    def _is_header(self, line: str) -> bool:
        """Return whether a line is the header, or its units, again: as many cells and none of them a number."""
        cells = self.layout.cells(line.strip().lstrip("#%/ "))
        return len(cells) == len(self.layout.names) > 1 and (
            [cell for cell in cells if cell] == [name for name in self.layout.names if name]
            or (
                not any(map(is_number, cells))
                and all(c in n for c, n in zip(cells, self.layout.names, strict=True))
            )
        )


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Rows as a table, whose columns of text are not yet known, and what is damaged in them."""

    table: Table
    damage: Damage


def open_text(file: Path) -> TableReader:
    """Open a table of text; one whose lines cannot be parted at LF is read as a whole.

    Raises
    ------
    DataRefused
        If it holds no table; where it is read, also if too many rows are damaged.
    """
    with file.open("rb") as stream:
        start = stream.read(READ_BYTES)
    is_whole = len(start) < READ_BYTES
    end = len(start) if is_whole else start.rfind(b"\n") + 1
    if start.startswith(_UTF_16) or start[1:4:2] == b"\0\0" or (start and not end):
        return in_blocks(_read_whole(file))
    lines = lines_of(decoded(start[:end], file))
    form = TextForm.of(lines, file)
    head = judged(form.table(file, lines[: form.layout.first + HEAD_ROWS], 0, is_last=is_whole), form)
    return TableReader(head, partial(_blocks, file, form, head), partial(_read_whole, file))


def _read_whole(file: Path) -> Table:
    if file.stat().st_size > MAX_FILE:
        found = f"{file.stat().st_size} bytes"
        raise DataRefused(file, None, found, f"at most {MAX_FILE}", "save it as .npz, or cut it", ErrorCode.TABLE)
    lines = lines_of(decoded(file.read_bytes(), file))
    form = TextForm.of(lines, file)
    part = form.table(file, lines, 0, is_last=True)
    damage, rows = part.damage, part.table.lines or []
    return judged(part, form, damage.note(form.layout, rows.__getitem__, file))


def _blocks(file: Path, form: TextForm, head: Table, wanted: Sequence[str]) -> Generator[Block]:
    at, size, done = 0, max(file.stat().st_size, 1), 0
    damage, line_of = Damage(), dict[int, int]()
    names = [head.name_of(name) for name in wanted]
    for raw in _parts(file):
        lines = lines_of(decoded_lines(raw))
        done += len(raw)
        part = form.table(file, lines, at, is_last=done >= size)
        at += len(lines)
        table, before = part.table, damage.rows
        damage.add(part.damage)
        line_of |= {before + row: table.line(row) for row in part.damage.places}
        if table.rows:
            yield Block({name: table.columns[name] for name in names}, done / size, table.lines or ())
    damage.note(form.layout, line_of.__getitem__, file)
    _refuse_text(file, form, damage, line_of, names)


def judged(part: Part, form: TextForm, text: tuple[str, ...] = ()) -> Table:
    """Return a table with its columns of text known; ``text`` is what is damaged as text."""
    table, damage = part.table, part.damage
    names = dict(zip(form.layout.names, form.scales.names, strict=True))
    return replace(
        table,
        unreadable={names[name]: cell for name, cell in damage.unreadable(form.layout).items()},
        notes=(*form.notes, *table.notes, *text),
        damaged=frozenset(damage.descriptions(form.layout)),
    )


def decoded(content: bytes, file: Path) -> str:
    """Return a file's bytes as text; raise `DataRefused` where they are none."""
    if content.startswith(_UTF_16):
        return content.decode("utf-16", "replace")
    head = content[:4096]
    if b"\0" in head and len(head) > 16 and head[1::2].count(0) > 0.9 * len(head[1::2]) and not head[::2].count(0):
        return content.decode("utf-16-le", "replace")
    plain = head.replace(b"\0", b"")
    if (b"\0" in head or _CONTROL.search(head)) and (
        len(_CONTROL.findall(plain)) > MAX_CONTROL * len(plain) or not plain.strip()
    ):
        raise DataRefused(
            file, None, "binary data", "a table as text, .mat, .npz or .parquet",
            "write a short reader that saves it as .npz (docs/how-to/logs.md)", ErrorCode.TABLE,
        )  # fmt: skip
    return decoded_lines(content)


def decoded_lines(content: bytes) -> str:
    """Return bytes as text in UTF-8, line by line in ISO-8859-1 where that is not what they are."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return "\n".join(decoded_text(line) for line in content.split(b"\n"))


def lines_of(text: str) -> list[str]:
    """Return the lines of a text, ended by CR LF, LF or CR; no other character ends one."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return lines[:-1] if not lines[-1] else lines


def _refuse_text(file: Path, form: TextForm, damage: Damage, line_of: Mapping[int, int], names: list[str]) -> None:
    """Refuse a column that was read as numbers where text was common in it: its first."""
    named = dict(zip(form.layout.names, form.scales.names, strict=True))
    for name, (row, cell) in damage.unreadable(form.layout).items():
        if named[name] in names:
            raise text_in_column(file, line_of[row], cell, name)


def _parts(file: Path) -> Iterator[bytes]:
    """Yield bytes that end with a line; the last line of all need not be whole."""
    rest = b""
    with file.open("rb") as stream:
        while chunk := stream.read(READ_BYTES):
            end = chunk.rfind(b"\n") + 1
            if not end and len(rest) + len(chunk) > MAX_LINE + READ_BYTES:
                raise DataRefused(
                    file,
                    None,
                    "a line of more than 1 MiB",
                    "lines of text",
                    "name another file",
                    code=ErrorCode.TABLE,
                )
            if end:
                yield rest + chunk[:end]
                rest = chunk[end:]
            else:
                rest += chunk
    if rest:
        yield rest
