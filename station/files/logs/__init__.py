"""Tables from elsewhere: a file each format, a line each in `LOG_FORMATS`, guesses from headers, campaigns."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from station.files.logs.by_suffix import read_by_suffix
from station.files.logs.log_table import LogTable
from station.files.logs.mat_log import read_mat_log
from station.files.logs.npz_log import read_npz_log
from station.files.logs.parquet_log import read_parquet_log
from station.files.logs.text_log import read_text_log

LOG_FORMATS: Mapping[str, Callable[[Path], LogTable]] = MappingProxyType({
    ".mat": read_mat_log,
    ".npz": read_npz_log,
    ".npy": read_npz_log,
    ".parquet": read_parquet_log,
})  # fmt: skip
"""By the file's suffix; every other is text."""


def read_log(file: Path) -> LogTable:
    """Read a table from elsewhere; raises `DataRefused` as `read_by_suffix`."""
    return read_by_suffix(file, LOG_FORMATS, read_text_log)
