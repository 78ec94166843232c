"""Text block by block: the layout is that of the first lines, and every row must have it."""

from collections.abc import Generator, Iterator, Sequence
from pathlib import Path

import numpy as np

from drivers.text_decoding import decoded_text
from station.errors import DataRefused
from station.files.log_blocks.log_blocks import HEAD_ROWS, Block, LogBlocks
from station.files.log_blocks.whole_table import whole_table
from station.files.logs.log_table import LogTable
from station.files.logs.text_log import (
    LOOKED_AT,
    Layout,
    decoded,
    has_all_cells,
    is_row,
    layout_of,
    read_text_log,
    values_of,
)  # fmt: skip

READ_BYTES = 2**21
MAX_LINE = 2**20


def text_blocks(file: Path) -> LogBlocks:
    """Open a table of text; one of UTF-16 is read whole."""
    with file.open("rb") as stream:
        start = stream.read(READ_BYTES)
    if start.startswith((b"\xff\xfe", b"\xfe\xff")):
        return whole_table(read_text_log(file))
    end = start.rfind(b"\n") + 1 if len(start) == READ_BYTES else len(start)
    lines = decoded(start[:end], file).splitlines()
    layout = layout_of(lines[:LOOKED_AT], file)
    head = _table(file, layout, lines[: layout.first + HEAD_ROWS], 0, is_last=len(start) < READ_BYTES)

    def read(wanted: Sequence[str]) -> Generator[Block]:
        at, size, done = 0, max(file.stat().st_size, 1), 0
        for part in _parts(file):
            lines = decoded_text(part).splitlines()
            done += len(part)
            table = _table(file, layout, lines, at, is_last=done >= size)
            at += len(lines)
            if table.rows:
                yield Block({name: table.column(name) for name in wanted}, done / size, table.lines)

    return LogBlocks(head, read)


def _parts(file: Path) -> Iterator[bytes]:
    """Yield bytes that end with a line; the last line of all need not be whole."""
    rest = b""
    with file.open("rb") as stream:
        while chunk := stream.read(READ_BYTES):
            end = chunk.rfind(b"\n") + 1
            if not end and len(rest) + len(chunk) > MAX_LINE + READ_BYTES:
                raise DataRefused(file, None, "a line of more than 1 MiB", "lines of text", "name another file")
            if end:
                yield rest + chunk[:end]
                rest = chunk[end:]
            else:
                rest += chunk
    if rest:
        yield rest


def _table(file: Path, layout: Layout, lines: Sequence[str], before: int, *, is_last: bool) -> LogTable:
    """Return rows as a table, ``before`` lines after the file's first; its last row only if it is whole."""
    first = max(layout.first - before, 0)
    kept = [i for i in range(first, len(lines)) if is_row(lines[i])]
    rows = [lines[i].replace(",", ".") if layout.has_decimal_comma else lines[i] for i in kept]
    if is_last and rows and not has_all_cells(rows[-1], layout):
        rows, kept = rows[:-1], kept[:-1]
    numbers = [before + i for i in kept]
    values, unreadable = values_of(rows, numbers, layout, file) if rows else (np.empty((0, len(layout.names))), {})
    columns = {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(layout.names)}
    moments = frozenset(layout.names[i] for i in layout.moments)
    return LogTable(file, columns, "", [i + 1 for i in numbers], unreadable, (), moments)
