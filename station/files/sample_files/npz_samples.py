"""Samples as ``.npz``: an array a column, not compressed."""

import os
import zipfile
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.files.sample_files.sample_file import SampleColumns
from station.files.sample_files.spooled_columns import SpooledColumns


class NpzSamples:
    """Writes an archive of arrays of doubles."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        self._path, self._names = path, columns.names
        self._spool = SpooledColumns(path, len(columns.names))

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in the units of their names."""
        self._spool.write(columns)

    def finish(self) -> None:
        """Put the columns together, on the disk."""
        header = {"descr": "<f8", "fortran_order": False, "shape": (self._spool.rows,)}
        with self._path.open("xb") as stream:
            with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
                for i, name in enumerate(self._names):
                    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                        np.lib.format.write_array_header_1_0(member, header)
                        self._spool.copy(i, member)
            stream.flush()
            os.fsync(stream.fileno())
        self._spool.close()

    def abandon(self) -> None:
        """Let go of the columns."""
        self._spool.close()
