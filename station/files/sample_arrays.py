"""Calibrated samples as columns: CSV, Parquet, NumPy and MATLAB files; and what every writer of samples does.

Formats that need a whole column at once spool each column into a file of doubles first.
"""

import os
import shutil
import struct
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused, cannot_write

NS_PER_S = 1e9


@dataclass(frozen=True, slots=True)
class SampleColumns:
    """The columns: ``names`` of all, the first seven in this order; ``rows`` that will come at most.

    ``is_si`` says that forces are in m/s2 and rates in rad/s; ``frame`` names their axes.
    """

    names: tuple[str, ...]
    rows: int
    frame: str
    is_si: bool


class SampleWriter(Protocol):
    """Writes a new file, or a folder; in memory that does not grow with it."""

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, ``columns`` (n,) in the order and units of the names."""
        ...

    def finish(self) -> None:
        """Make the file whole, on the disk."""
        ...

    def abandon(self) -> None:
        """Release the file, which is taken away by the one who asked for it."""
        ...


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
        """Release the file."""
        self._stream.close()


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
        """Release the file."""
        self._writer.close()


COPY_BYTES = 2**20


class SpooledColumns:
    """Doubles of each column, alongside the file that is made of them; needs as much room again."""

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
        """Release the columns."""
        self._spool.close()


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
        """Release the columns."""
        self._spool.close()
