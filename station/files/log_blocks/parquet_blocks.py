"""``.parquet`` block by block."""

from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.log_blocks.log_blocks import BLOCK_ROWS, HEAD_ROWS, Block, LogBlocks, undamaged
from station.files.logs.damage import DAMAGED_WITHIN, in_a_line
from station.files.logs.log_table import LogTable
from station.files.logs.parquet_log import column_values

PAGE_BYTES = 2**16  # read at a time of each column, in place of a whole row group


def parquet_blocks(file: Path) -> LogBlocks:
    """Open a ``.parquet``; raise `DataRefused` where it is none or holds no numbers."""
    import pyarrow.parquet as parquet

    try:
        with parquet.ParquetFile(file) as opened:
            rows = opened.metadata.num_rows
            first = next(opened.iter_batches(HEAD_ROWS), None)
            columns, moments = _numbers_of(first)
    except FileNotFoundError:
        raise
    except DAMAGED_WITHIN as error:  # pyarrow's own are of these kinds
        raise DataRefused(
            file, None, f"no readable table ({in_a_line(error)})", "a .parquet", code=ErrorCode.TABLE
        ) from None
    if not columns:
        raise DataRefused(
            file, None, "no column of numbers", "columns of numbers, a row a sample", code=ErrorCode.COLUMNS
        )

    def read(wanted: Sequence[str]) -> Generator[Block]:
        done = 0
        with parquet.ParquetFile(file, buffer_size=PAGE_BYTES, pre_buffer=False) as opened:
            for batch in opened.iter_batches(BLOCK_ROWS, columns=list(wanted), use_threads=False):
                done += batch.num_rows
                yield Block({name: _numbers(batch.column(name)) for name in wanted}, done / max(rows, 1))

    head = LogTable(file, columns, "", moments=frozenset(moments))
    return LogBlocks(head, lambda wanted: undamaged(read(wanted), file))


def _numbers_of(batch: Any) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the first rows by column, of those that hold numbers, and which of them are moments."""
    columns, moments = dict[str, FloatArray](), list[str]()
    if batch is not None and batch.num_rows > 1:
        for name, column in zip(batch.schema.names, batch.columns, strict=True):
            if (values := column_values(column)) is not None:
                columns[name], is_moment = values
                moments += [name] if is_moment else []
    return columns, moments


def _numbers(column: Any) -> FloatArray:
    found = column_values(column)
    return np.full(len(column), np.nan) if found is None else found[0]
