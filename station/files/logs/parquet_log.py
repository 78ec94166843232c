"""``.parquet``: columns of numbers; needs the extra ``parquet``."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.logs.log_table import LogTable


def read_parquet_log(file: Path) -> LogTable:
    """Read a ``.parquet``; raise `DataRefused` where it is none, holds no numbers or pyarrow is not installed."""
    try:
        import pyarrow.parquet as parquet
        from pyarrow import ArrowException
    except ImportError:
        remedy = "pip install 'fog-station[parquet]', or save the log as .csv or .npz"
        raise DataRefused(file, None, "no pyarrow to read it with", "the extra parquet", remedy) from None
    try:
        found: Any = parquet.read_table(file)
    except (ArrowException, ValueError) as error:
        first = str(error).splitlines()[0]
        raise DataRefused(file, None, f"no readable table ({first})", "a .parquet") from None
    columns = dict[str, FloatArray]()
    for name in found.column_names:
        values = found.column(name).to_numpy()
        if values.dtype.kind == "M":  # a moment: seconds since 1970
            columns[name] = values.astype("datetime64[ns]").astype(np.int64) / 1e9
        elif values.dtype.kind in "buif":
            columns[name] = values.astype(np.float64)
    if not columns or len(next(iter(columns.values()))) < 2:
        raise DataRefused(file, None, "no column of numbers", "columns of numbers, a row a sample")
    return LogTable(file, columns, hashlib.sha256(file.read_bytes()).hexdigest())
