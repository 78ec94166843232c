"""Samples as CSV: numbers that read back to the same bits; nothing where there is none."""

import os
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.files.sample_files.sample_file import SampleColumns


class CsvSamples:
    """Writes CSV with a header."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        self._stream = path.open("x", encoding="ascii", newline="")
        self._stream.write(",".join(columns.names) + "\n")

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in the units of their names."""
        rows = np.stack(columns, axis=1).tolist()
        text = "\n".join([",".join(map(repr, row)) for row in rows])
        self._stream.write(text.replace("nan", "") + "\n" if rows else "")

    def finish(self) -> None:
        """Put the file on the disk."""
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._stream.close()

    def abandon(self) -> None:
        """Let go of the file."""
        self._stream.close()
