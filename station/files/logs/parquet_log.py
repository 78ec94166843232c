"""``.parquet``: columns of numbers."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.logs.array_columns import seconds_of
from station.files.logs.damage import DAMAGED_WITHIN, in_a_line
from station.files.logs.log_table import LogTable


def read_parquet_log(file: Path) -> LogTable:
    """Read a ``.parquet``; raise `DataRefused` where it is none or holds no numbers."""
    import pyarrow.parquet as parquet

    try:
        found: Any = parquet.read_table(file)
    except FileNotFoundError:
        raise
    except DAMAGED_WITHIN as error:  # pyarrow's own are of these kinds
        raise DataRefused(
            file, None, f"no readable table ({in_a_line(error)})", "a .parquet", code=ErrorCode.TABLE
        ) from None
    columns, moments = dict[str, FloatArray](), list[str]()
    for name in found.column_names:
        if (values := column_values(found.column(name))) is not None:
            columns[name], is_moment = values
            moments += [name] if is_moment else []
    if not columns or len(next(iter(columns.values()))) < 2:
        raise DataRefused(
            file, None, "no column of numbers", "columns of numbers, a row a sample", code=ErrorCode.COLUMNS
        )
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    return LogTable(file, columns, sha256, moments=frozenset(moments))


def column_values(column: Any) -> tuple[FloatArray, bool] | None:
    """Return a pyarrow column as numbers (n,), and whether they are moments in s; None if it holds none."""
    plain = _plain(column)
    values = plain.to_numpy(zero_copy_only=False) if hasattr(plain, "buffers") else plain.to_numpy()
    if values.dtype.kind not in "buifmM":
        return None
    return seconds_of(values).astype(np.float64), values.dtype.kind in "mM"


def _plain(column: Any) -> Any:
    """Return decimals as numbers and times of the day as spans of time since midnight."""
    from pyarrow import duration, float64, int64, types

    if types.is_decimal(column.type):
        return column.cast(float64())
    if types.is_time32(column.type):
        column = column.cast("time64[us]")
    if types.is_time64(column.type):
        return column.cast(int64()).cast(duration(column.type.unit))
    return column
