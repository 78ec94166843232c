"""Text block by block: the form is that of the first lines, and every row must have it."""

from collections.abc import Generator, Iterator, Mapping, Sequence
from pathlib import Path

from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.log_blocks.log_blocks import HEAD_ROWS, Block, LogBlocks
from station.files.log_blocks.whole_table import whole_table
from station.files.logs.log_table import text_in_column
from station.files.logs.text_log import TextForm, decoded, decoded_lines, judged, lines_of, read_text_log
from station.files.logs.text_rows import Damage

READ_BYTES = 2**21
MAX_LINE = 2**20


def text_blocks(file: Path) -> LogBlocks:
    """Open a table of text; one of UTF-16 is read whole."""
    with file.open("rb") as stream:
        start = stream.read(READ_BYTES)
    if start.startswith((b"\xff\xfe", b"\xfe\xff")) or start[1:4:2] == b"\0\0":
        return whole_table(read_text_log(file))
    is_whole = len(start) < READ_BYTES
    end = len(start) if is_whole else start.rfind(b"\n") + 1
    lines = lines_of(decoded(start[:end], file))
    form = TextForm.of(lines, file)
    head = judged(form.table(file, lines[: form.layout.first + HEAD_ROWS], 0, is_last=is_whole), form)

    def read(wanted: Sequence[str]) -> Generator[Block]:
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
            line_of |= {before + row: table.line(row) or 0 for row in part.damage.places}
            if table.rows:
                yield Block({name: table.columns[name] for name in names}, done / size, table.lines)
        damage.note(form.layout, line_of.__getitem__, file)
        _refuse_text(file, form, damage, line_of, names)

    return LogBlocks(head, read)


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
