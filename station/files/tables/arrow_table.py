"""``.parquet`` and ``.feather`` (Arrow): columns of numbers, batch by batch."""

from collections.abc import Callable, Generator, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.table import (
    BLOCK_ROWS,
    DAMAGED_WITHIN,
    HEAD_ROWS,
    Block,
    Table,
    TableReader,
    in_a_line,
    seconds_of,
    undamaged,
)

PAGE_BYTES = 2**16  # read at a time of each column, in place of a whole row group
_Batches = Callable[[Path, Sequence[str] | None, int], Iterator[tuple[Any, float]]]


def open_parquet(file: Path) -> TableReader:
    """Open a ``.parquet``; raise `DataRefused` where it is none or holds no numbers."""
    return _opened(file, _parquet_batches, "a .parquet")


def open_feather(file: Path) -> TableReader:
    """Open a ``.feather`` of version 2; raise `DataRefused` where it is none or holds no numbers."""
    return _opened(file, _feather_batches, "a .feather of version 2")


def _parquet_batches(file: Path, names: Sequence[str] | None, rows: int) -> Iterator[tuple[Any, float]]:
    """Yield batches, and how much of the file has been read with each."""
    from pyarrow import parquet

    done = 0
    with parquet.ParquetFile(file, buffer_size=PAGE_BYTES, pre_buffer=False) as opened:
        total = max(opened.metadata.num_rows, 1)
        for batch in opened.iter_batches(rows, columns=names, use_threads=False):
            done += batch.num_rows
            yield batch, done / total


def _feather_batches(file: Path, names: Sequence[str] | None, rows: int) -> Iterator[tuple[Any, float]]:
    """Yield batches, and how much of the file has been read with each."""
    import pyarrow

    with pyarrow.memory_map(str(file)) as mapped, pyarrow.ipc.open_file(mapped) as opened:
        for i in range(opened.num_record_batches):
            batch = opened.get_batch(i)
            for begin in range(0, batch.num_rows, rows):
                part = batch.slice(begin, rows)
                share = min(begin + rows, batch.num_rows) / batch.num_rows
                yield part if names is None else part.select(names), (i + share) / opened.num_record_batches


def _opened(file: Path, batches: _Batches, expected: str) -> TableReader:
    try:
        first, _ = next(batches(file, None, HEAD_ROWS), (None, 0))
        columns, moments = _numbers_of(first)
    except FileNotFoundError:
        raise
    except DAMAGED_WITHIN as error:  # pyarrow's own are of these kinds
        raise DataRefused(
            file, None, f"no readable table ({in_a_line(error)})", expected, code=ErrorCode.TABLE
        ) from None
    if not columns:
        raise DataRefused(
            file, None, "no column of numbers", "columns of numbers, a row a sample", code=ErrorCode.COLUMNS
        )

    def read(wanted: Sequence[str]) -> Generator[Block]:
        for batch, done in batches(file, list(wanted), BLOCK_ROWS):
            yield Block({name: _numbers(batch.column(name)) for name in wanted}, done)

    head = Table(file, columns, moments=frozenset(moments))
    return TableReader(head, lambda wanted: undamaged(read(wanted), file))


def _numbers_of(batch: Any) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the first rows by column, of those that hold numbers, and which of them are moments."""
    columns, moments = dict[str, FloatArray](), list[str]()
    if batch is not None and batch.num_rows > 1:
        for name, column in zip(batch.schema.names, batch.columns, strict=True):
            if (values := _values(column)) is not None:
                columns[name] = seconds_of(values)
                moments += [name] if values.dtype.kind in "mM" else []
    return columns, moments


def _numbers(column: Any) -> FloatArray:
    found = _values(column)
    return np.full(len(column), np.nan) if found is None else seconds_of(found)


def _values(column: Any) -> Any:
    """Return a column as numpy's numbers, moments or spans of time (n,), None if it holds none.

    Decimals are numbers, times of the day spans of time since midnight.
    """
    from pyarrow import duration, float64, int64, types

    if types.is_decimal(column.type):
        column = column.cast(float64())
    elif types.is_time32(column.type):
        column = column.cast("time64[us]")
    if types.is_time64(column.type):
        column = column.cast(int64()).cast(duration(column.type.unit))
    values = column.to_numpy(zero_copy_only=False)
    return values if values.dtype.kind in "buifmM" else None
