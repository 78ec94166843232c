"""Text with a row a line: any delimiter, with or without a header, with lines above it that are neither.

The form is that of the first lines, and every row must have it. A header may state scales: ``tscale,0.001`` above
the table of a .gcsv (docs.gyroflow.xyz, "Gyroflow IMU log": t times tscale is s, gx times gscale rad/s, ax times
ascale g).
"""

import re
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from drivers.text_decoding import decoded_text
from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.table import HEAD_ROWS, Block, Table, TableReader, text_in_column
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


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Rows as numbers (n, columns), the line of each, and what is damaged in them.

    ``headers`` is how often the header is repeated among them, ``notes`` which incomplete end is not used.
    """

    lines: Sequence[int]
    values: FloatArray
    damage: Damage
    headers: int = 0
    notes: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class TextForm:
    """How a text is read: the layout of its rows, and the scales that the lines above its table state."""

    file: Path
    layout: Layout
    scales: StatedScales

    @classmethod
    def of(cls, lines: Sequence[str], file: Path) -> "TextForm":
        """Return the form of a text by its first lines; raise `DataRefused` of no table."""
        layout = layout_of(lines[:LOOKED_AT], file)
        return cls(file, layout, stated_scales(lines[: layout.first], layout.names))

    def parts(self) -> Iterator[tuple[Part, float]]:
        """Yield all rows, some at a time, and how much of the file has been read with them."""
        before = 0
        for text, done in _texts(self.file):
            lines = lines_of(text)
            yield self.part(lines, before, is_last=done == 1), done
            before += len(lines)

    def part(self, lines: Sequence[str], before: int, *, is_last: bool) -> Part:
        """Return rows of the text, ``before`` lines after its first."""
        layout, notes = self.layout, list[str]()
        first = max(layout.first - before, 0)
        kept = [i for i in range(first, len(lines)) if lines[i][:1] in OF_NUMBERS or is_row(lines[i].strip("\0"))]
        again = {i for i in kept if lines[i][:1] not in OF_NUMBERS and self._is_header(lines[i])}
        kept = [i for i in kept if i not in again]
        ends = [("first", 0)] if not before and kept and kept[0] == 0 else []
        ends += [("last", -1)] if is_last else []
        for which, end in ends:
            if kept and (before or len(kept) > 2) and len(layout.cells(lines[kept[end]])) < len(layout.names):
                notes.append(f"line {kept[end] + 1 + before}, the {which}, is incomplete and not used")
                del kept[end]
        rows = [lines[i].strip("\0") if "\0" in lines[i] else lines[i] for i in kept]
        values, damage = values_of(rows, layout) if rows else (np.empty((0, len(layout.names))), Damage())
        values *= self.scales.factors
        return Part([before + i + 1 for i in kept], values, damage, len(again), notes)

    def columns(self, values: FloatArray) -> dict[str, FloatArray]:
        """Return the rows' numbers ``values`` (n, columns) by column."""
        return {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(self.scales.names)}

    def table(self, parts: Iterable[Part], *, is_whole: bool) -> Table:
        """Return rows as a table; raise `DataRefused` if too many of the whole are damaged."""
        damage, lines, values, notes, headers = Damage(), list[int](), list[FloatArray](), list[str](), 0
        for part in parts:
            damage.add(part.damage)
            lines += part.lines
            values.append(part.values)
            notes += part.notes
            headers += part.headers
        if headers:
            notes.insert(0, f"the header is repeated {plural(headers, 'time')}")
        notes += damage.note(self.layout, lines.__getitem__, self.file) if is_whole else ()
        return Table(
            self.file, self.columns(damage.without_misprints(np.concatenate(values))), lines=lines,
            unreadable=damage.unreadable(self.scales.names), notes=(*self._notes(), *notes),
            moments=frozenset(self.scales.names[i] for i in self.layout.moments),
            time_scale_s=self.scales.time_s, damaged=frozenset(damage.descriptions(self.layout)),
            text_of=self.cell,
        )  # fmt: skip

    def cell(self, line: int, name: str) -> str:
        """Return a cell of a line, counted from 1, as the file writes it."""
        every = (each for text, _ in _texts(self.file) for each in lines_of(text))
        row = next(islice(every, line - 1, None))
        return self.layout.cells(row.strip("\0"))[self.scales.names.index(name)]

    def _notes(self) -> Iterator[str]:
        """Yield what was assumed of the form."""
        yield from self.layout.notes
        if self.layout.has_decimal_comma:
            yield "decimal commas"
        if self.layout.grouping:
            yield f"thousands parted by {self.layout.grouping!r}"
        yield from self.scales.notes

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


def open_text(file: Path) -> TableReader:
    """Open a table of text.

    Raise `DataRefused` if it holds no table; where it is read, also if too many rows are damaged.
    """
    with closing(_texts(file)) as texts:
        text, done = next(texts, ("", 1.0))
    lines = lines_of(text)
    form = TextForm.of(lines, file)
    head = form.table([form.part(lines[: form.layout.first + HEAD_ROWS], 0, is_last=done == 1)], is_whole=False)

    def whole() -> Table:
        _refuse_large(file)
        return form.table((part for part, _ in form.parts()), is_whole=True)

    return TableReader(head, partial(_blocks, form, head), whole)


def _blocks(form: TextForm, head: Table, wanted: Sequence[str]) -> Generator[Block]:
    damage, line_of = Damage(), dict[int, int]()
    names = [head.name_of(name) for name in wanted]
    for part, done in form.parts():
        line_of |= {damage.rows + row: part.lines[row] for row in part.damage.places}
        damage.add(part.damage)
        if part.lines:
            columns = form.columns(part.damage.without_misprints(part.values))
            yield Block({name: columns[name] for name in names}, done, part.lines)
    damage.note(form.layout, line_of.__getitem__, form.file)
    for name, (row, cell) in damage.unreadable(form.scales.names).items():
        if name in names:
            raise text_in_column(form.file, line_of[row], cell, name)


def _texts(file: Path) -> Generator[tuple[str, float]]:
    """Yield whole lines of a file as text, and how much of it has been read with them.

    A file whose lines LF does not part comes as a whole.
    """
    size, done, rest = max(file.stat().st_size, 1), 0, b""
    with file.open("rb") as stream:
        chunk = stream.read(READ_BYTES)
        is_one_line = len(chunk) == READ_BYTES and b"\n" not in chunk
        if is_one_line or chunk.startswith(_UTF_16) or chunk[1:4:2] == b"\0\0":
            _refuse_large(file)
            chunk += stream.read()
            yield decoded(chunk, file), 1.0
            return
        while chunk:
            following = stream.read(READ_BYTES)
            end = chunk.rfind(b"\n") + 1 if following else len(chunk)
            if not end and len(rest) + len(chunk) > MAX_LINE + READ_BYTES:
                raise DataRefused(
                    file, None, "a line of more than 1 MiB", "lines of text", "name another file", ErrorCode.TABLE
                )
            rest += chunk[:end]
            if end:
                text = decoded_lines(rest) if done else decoded(rest, file)
                done += len(rest)
                yield text, min(done / size, 1.0)
            rest = chunk[end:] if end else rest + chunk
            chunk = following


def _refuse_large(file: Path) -> None:
    if (size := file.stat().st_size) > MAX_FILE:
        found = f"{size} bytes"
        raise DataRefused(file, None, found, f"at most {MAX_FILE}", "save it as .npz, or cut it", ErrorCode.TABLE)


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
