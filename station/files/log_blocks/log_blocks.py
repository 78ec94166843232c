"""A table from elsewhere that is read block by block."""

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.logs.damage import DAMAGED_WITHIN, in_a_line
from station.files.logs.log_table import LogTable

HEAD_ROWS = 2000  # of which it is guessed what the columns hold
BLOCK_ROWS = 2**15


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Rows of a table: columns by name, each (n,), nan where a cell is empty.

    ``done`` is how much of the file has been read with them, 0 to 1. ``lines`` are their numbers, None where a
    file has no lines.
    """

    columns: Mapping[str, FloatArray]
    done: float
    lines: Sequence[int] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LogBlocks:
    """A table: ``head`` are its first rows, with the names of all columns; ``read`` yields named ones."""

    head: LogTable
    read: Callable[[Sequence[str]], Generator[Block]]


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
