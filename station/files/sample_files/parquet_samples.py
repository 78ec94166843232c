"""Samples as Parquet."""

import os
from pathlib import Path
from typing import Any

from procedures.arrays import FloatArray
from station.files.sample_files.sample_file import SampleColumns

GROUP_ROWS = 2**17  # in memory until they are written


class ParquetSamples:
    """Writes Parquet, a column of doubles each; what is not known is null."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        import pyarrow
        import pyarrow.parquet as parquet

        self._arrow: Any = pyarrow
        self._path = path
        self._schema = pyarrow.schema([(name, pyarrow.float64()) for name in columns.names])
        # the bits of a measured value hardly repeat: no dictionary
        self._writer = parquet.ParquetWriter(path, self._schema, use_dictionary=False, compression="snappy")
        self._waiting, self._rows = list[Any](), 0

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in the units of their names."""
        arrays = [self._arrow.array(column, from_pandas=True) for column in columns]
        self._waiting.append(self._arrow.record_batch(arrays, schema=self._schema))
        self._rows += len(columns[0])
        if self._rows >= GROUP_ROWS:
            self._flush()

    def _flush(self) -> None:
        if self._rows:
            self._writer.write_table(self._arrow.Table.from_batches(self._waiting), row_group_size=self._rows)
        self._waiting, self._rows = [], 0

    def finish(self) -> None:
        """Put the file on the disk."""
        self._flush()
        self._writer.close()
        with self._path.open("rb") as stream:
            os.fsync(stream.fileno())

    def abandon(self) -> None:
        """Let go of the file."""
        self._writer.close()
