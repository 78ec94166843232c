"""Text with a row a line: any delimiter, with or without a header, with lines above it that are neither."""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.text_decoding import decoded_text
from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.logs.log_table import LogTable
from station.files.logs.stated_scales import StatedScales, stated_scales
from station.files.logs.text_layout import LOOKED_AT, Layout, is_number, is_row, layout_of
from station.files.logs.text_rows import Damage, values_of
from station.text.plural import plural

MAX_FILE = 2**29  # bytes: eight times as much memory while it is read and diagnosed
OF_NUMBERS = frozenset("0123456789+-.")  # a row that begins so is no comment
MAX_CONTROL = 0.05  # of bytes of text that are none of it: NULs of a card that lost power, bytes of a bad line
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


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

    def table(self, file: Path, lines: Sequence[str], before: int, sha256: str = "", *, is_last: bool) -> "Part":
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
        table = LogTable(
            file, columns, sha256, numbers, {}, tuple(notes), moments, time_scale_s=self.scales.time_s
        )
        return Part(table, damage)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed of the form."""
        layout, said = self.layout, list[str]()
        if layout.has_decimal_comma:
            said.append("decimal commas")
        if layout.grouping:
            said.append(f"thousands parted by {layout.grouping!r}")
        return (*layout.notes, *said, *self.scales.notes)

    def _is_header(self, line: str) -> bool:
        """Say whether a line is the header, or its units, again: as many cells and none of them a number."""
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

    table: LogTable
    damage: Damage


def read_text_log(file: Path) -> LogTable:
    """Read a text log.

    Raises
    ------
    DataRefused
        If it holds no table, or too many rows of it are damaged.
    """
    if file.stat().st_size > MAX_FILE:
        found = f"{file.stat().st_size} bytes"
        raise DataRefused(file, None, found, f"at most {MAX_FILE}", "save it as .npz, or cut it", ErrorCode.TABLE)
    content = file.read_bytes()
    lines = lines_of(decoded(content, file))
    form = TextForm.of(lines, file)
    part = form.table(file, lines, 0, hashlib.sha256(content).hexdigest(), is_last=True)
    damage, rows = part.damage, part.table.lines or []
    return judged(part, form, damage.note(form.layout, rows.__getitem__, file))


def judged(part: Part, form: TextForm, said: tuple[str, ...] = ()) -> LogTable:
    """Return a table with its columns of text known; ``said`` is what is damaged in words."""
    table, damage = part.table, part.damage
    names = dict(zip(form.layout.names, form.scales.names, strict=True))
    unreadable = {names[name]: cell for name, cell in damage.unreadable(form.layout).items()}
    return LogTable(
        table.file, table.columns, table.sha256, table.lines, unreadable, (*form.notes, *table.notes, *said),
        table.moments, table.time_scale_s, frozenset(damage.said(form.layout)),
    )  # fmt: skip


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
