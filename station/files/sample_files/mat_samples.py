"""Samples as ``.mat`` of version 5, a variable a column.  Source: MATLAB, MAT-File Format, chapter 1 (R2019b)."""

import os
import struct
from pathlib import Path

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.sample_files.sample_file import SampleColumns
from station.files.sample_files.spooled_columns import SpooledColumns

LARGEST = 2**31 - 1  # bytes: lengths in the file are 32 bits, and readers take them with a sign
MAX_NAME = 63  # characters
_INT8, _INT32, _UINT32, _DOUBLE, _MATRIX, _CLASS = 1, 5, 6, 9, 14, 6  # data types, and the class of doubles


class MatSamples:
    """Writes a MATLAB file; one beyond 2 GB is refused before it is begun."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        if (size := 8 * columns.rows * len(columns.names)) > LARGEST:
            found = f"{size / 1e9:.1f} GB of samples"
            raise DataRefused(path, None, found, "at most 2 GB in a .mat", "name it .npz or .parquet")
        self._path, self._names = path, columns.names
        self._spool = SpooledColumns(path, len(columns.names))

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in the units of their names."""
        self._spool.write(columns)

    def finish(self) -> None:
        """Put the columns together, on the disk."""
        rows = self._spool.rows
        with self._path.open("xb") as stream:
            stream.write(
                b"MATLAB 5.0 MAT-file, calibrated samples".ljust(124) + struct.pack("<H2s", 0x0100, b"IM")
            )
            for i, name in enumerate(self._names):
                word = name[:MAX_NAME].encode()
                head = struct.pack("<IIII", _UINT32, 8, _CLASS, 0) + struct.pack("<IIii", _INT32, 8, rows, 1)
                head += struct.pack("<II", _INT8, len(word)) + word + bytes(-len(word) % 8)
                head += struct.pack("<II", _DOUBLE, 8 * rows)
                stream.write(struct.pack("<II", _MATRIX, len(head) + 8 * rows) + head)
                self._spool.copy(i, stream)
            stream.flush()
            os.fsync(stream.fileno())
        self._spool.close()

    def abandon(self) -> None:
        """Let go of the columns."""
        self._spool.close()
