"""Tables from elsewhere read block by block, in memory that does not grow with them: a file each format."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from station.files.log_blocks.log_blocks import LogBlocks
from station.files.log_blocks.npz_blocks import npy_blocks, npz_blocks
from station.files.log_blocks.parquet_blocks import parquet_blocks
from station.files.log_blocks.text_blocks import text_blocks
from station.files.log_blocks.whole_table import mat_blocks
from station.files.logs.by_suffix import read_by_suffix

BLOCK_FORMATS: Mapping[str, Callable[[Path], LogBlocks]] = MappingProxyType({
    ".mat": mat_blocks,
    ".npz": npz_blocks,
    ".npy": npy_blocks,
    ".parquet": parquet_blocks,
})  # fmt: skip
"""By the file's suffix; every other is text."""


def open_blocks(file: Path) -> LogBlocks:
    """Open a table from elsewhere; raises `DataRefused` as `read_by_suffix`."""
    return read_by_suffix(file, BLOCK_FORMATS, text_blocks)
