"""Columns kept in files of their own until all rows are there: for formats that hold a column after the other."""

import shutil
from pathlib import Path
from typing import IO

from procedures.arrays import FloatArray
from station.errors import cannot_write

COPY_BYTES = 2**20


class SpooledColumns:
    """Doubles of each column, beside the file that is made of them; needs as much room again."""

    def __init__(self, beside: Path, count: int) -> None:
        self._folder = beside.with_name(f"{beside.name}.columns")
        self._folder.mkdir()
        try:
            self._streams = [(self._folder / str(i)).open("w+b") for i in range(count)]
        except OSError as error:
            self.close()
            raise cannot_write(beside, error) from error
        self.rows = 0

    def write(self, columns: list[FloatArray]) -> None:
        """Keep rows, columns (n,) in whatever unit."""
        for stream, column in zip(self._streams, columns, strict=True):
            stream.write(column.astype("<f8").tobytes())
        self.rows += len(columns[0])

    def copy(self, column: int, into: IO[bytes]) -> None:
        """Copy a column's bytes to a file."""
        self._streams[column].seek(0)
        shutil.copyfileobj(self._streams[column], into, COPY_BYTES)

    def close(self) -> None:
        """Take the files away."""
        for stream in getattr(self, "_streams", ()):
            stream.close()
        shutil.rmtree(self._folder, ignore_errors=True)
