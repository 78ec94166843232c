"""Tables that cannot be read in parts: of ``.mat`` the whole is read, and handed on in blocks."""

from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path

from station.files.log_blocks.log_blocks import BLOCK_ROWS, HEAD_ROWS, Block, LogBlocks
from station.files.logs.log_table import LogTable
from station.files.logs.mat_log import read_mat_log


def mat_blocks(file: Path) -> LogBlocks:
    """Open a ``.mat``."""
    return whole_table(read_mat_log(file))


def whole_table(table: LogTable) -> LogBlocks:
    """Return a table that has been read, block by block."""

    def read(wanted: Sequence[str]) -> Generator[Block]:
        columns = {name: table.column(name) for name in wanted}
        for begin in range(0, table.rows, BLOCK_ROWS):
            end = min(begin + BLOCK_ROWS, table.rows)
            lines = None if table.lines is None else table.lines[begin:end]
            yield Block({name: each[begin:end] for name, each in columns.items()}, end / table.rows, lines)

    lines = None if table.lines is None else table.lines[:HEAD_ROWS]
    head = replace(table, columns={name: each[:HEAD_ROWS] for name, each in table.columns.items()}, lines=lines)
    return LogBlocks(head, read)
