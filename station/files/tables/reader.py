"""Any table of numbers: text of every dialect, ``.parquet``, ``.feather``, ``.npz``, ``.npy``, ``.mat``.

`open_table` reads block by block, in memory that does not grow with the file; `read_table` reads the whole.
"""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from station.files.opening import unreadable
from station.files.tables.binary_tables import open_feather, open_mat, open_npz, open_parquet
from station.files.tables.table import Table, TableReader
from station.files.tables.text_table import open_text

TABLE_FORMATS: Mapping[str, Callable[[Path], TableReader]] = MappingProxyType({
    ".mat": open_mat,
    ".npz": open_npz,
    ".npy": open_npz,
    ".parquet": open_parquet,
    ".feather": open_feather,
})  # fmt: skip
"""By the file's suffix; every other is text."""
T = TypeVar("T")


def open_table(file: Path) -> TableReader:
    """Open a table.

    Raise `DataRefused` if the file cannot be read or holds no table: with file, place, found, expected and what to
    do.
    """
    return _accessed(file, TABLE_FORMATS.get(file.suffix.lower(), open_text))


def read_table(file: Path) -> Table:
    """Read the whole of a table; raises `DataRefused` as `open_table`, and if its rows are damaged."""
    return _accessed(file, _read)


def _read(file: Path) -> Table:
    table = open_table(file).whole()
    with file.open("rb") as stream:
        return replace(table, sha256=hashlib.file_digest(stream, "sha256").hexdigest())


def _accessed(file: Path, read: Callable[[Path], T]) -> T:
    try:
        return read(file)
    except OSError as error:
        raise unreadable(file, error) from None
