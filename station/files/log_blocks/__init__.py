"""Tables from elsewhere read block by block, in memory that does not grow with them: a file each format."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from station.errors import DataRefused
from station.files.log_blocks.log_blocks import LogBlocks
from station.files.log_blocks.npz_blocks import npy_blocks, npz_blocks
from station.files.log_blocks.parquet_blocks import parquet_blocks
from station.files.log_blocks.text_blocks import text_blocks
from station.files.log_blocks.whole_table import mat_blocks

BLOCK_FORMATS: Mapping[str, Callable[[Path], LogBlocks]] = MappingProxyType({
    ".mat": mat_blocks,
    ".npz": npz_blocks,
    ".npy": npy_blocks,
    ".parquet": parquet_blocks,
})  # fmt: skip
"""By the file's suffix; every other is text."""


def open_blocks(file: Path) -> LogBlocks:
    """Open a table from elsewhere.

    Raises
    ------
    DataRefused
        If the file cannot be read or holds no table: with file, place, found, expected and what to do.
    """
    try:
        return BLOCK_FORMATS.get(file.suffix.lower(), text_blocks)(file)
    except OSError as error:
        found = error.strerror or str(error)
        raise DataRefused(file, None, found.lower(), "a readable file", "name another") from None
