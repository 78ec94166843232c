"""Calibrated samples as files, one line in `WRITERS` for each format: columns, MCAP and ROS 2 bags.

Columns are CSV, Parquet, NumPy and MATLAB. Formats that need a whole column at once spool each column into a file
of doubles first.
"""

import shutil
import struct
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, Protocol

import numpy as np

from fixtures_db.folder_on_disk import sync_file, sync_folder
from procedures.arrays import FloatArray
from procedures.optional_libraries import ExtraMissing
from station.errors import DataRefused, cannot_write
from station.files.mcap_files.schemas import SAMPLE, TOPIC, built, numbered, sample_message
from station.files.mcap_files.writer import GrowingFile, new_channel

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
        sync_file(self._stream)
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
            sync_file(stream)

    def abandon(self) -> None:
        """Release the file."""
        self._writer.close()


COPY_BYTES = 2**20


class SpooledColumns:
    """Doubles of each column, alongside the file that is made of them; needs as much room again."""

    def __init__(self, target: Path, count: int) -> None:
        self._folder = target.with_name(f"{target.name}.columns")
        self._folder.mkdir()
        try:
            self._streams = [(self._folder / str(i)).open("w+b") for i in range(count)]
        except OSError as error:
            self.close()
            raise cannot_write(target, error) from error
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


class _SpooledSamples:
    """Keeps the columns until all rows are there."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        self._path, self._names = path, columns.names
        self._spool = SpooledColumns(path, len(columns.names))

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in the units of their names."""
        self._spool.write(columns)

    def abandon(self) -> None:
        """Release the columns."""
        self._spool.close()


class MatSamples(_SpooledSamples):
    """Writes a MATLAB file; one beyond 2 GB is refused before it is begun."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        if (size := 8 * columns.rows * len(columns.names)) > LARGEST:
            found = f"{size / 1e9:.1f} GB of samples"
            raise DataRefused(path, None, found, "at most 2 GB in a .mat", "name it .npz or .parquet")
        super().__init__(path, columns)

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
            sync_file(stream)
        self._spool.close()


class NpzSamples(_SpooledSamples):
    """Writes an archive of arrays of doubles."""

    def finish(self) -> None:
        """Put the columns together, on the disk."""
        header = {"descr": "<f8", "fortran_order": False, "shape": (self._spool.rows,)}
        with self._path.open("xb") as stream:
            with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
                for i, name in enumerate(self._names):
                    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                        np.lib.format.write_array_header_1_0(member, header)
                        self._spool.copy(i, member)
            sync_file(stream)
        self._spool.close()


WIRE_64 = 1  # the wire type of doubles


class McapSamples(GrowingFile):
    """Writes MCAP; the log time is ``t_s`` in ns. A message has all columns, nan where one is not known."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        super().__init__(path)
        names = ["temperature_c" if name == "temp_c" else name for name in columns.names]
        self._channel = new_channel(self._writer, TOPIC, SAMPLE, built(sample_message(names))[0])
        keys = [_varint(number << 3 | WIRE_64) for number in numbered(names).values()]
        self._row = np.dtype([(f"{i}{part}", kind) for i, key in enumerate(keys)
                              for part, kind in (("k", f"S{len(key)}"), ("v", "<f8"))])  # fmt: skip
        self._keys = keys
        self._count = 0

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in the units of their names."""
        at = np.rint(columns[0] * NS_PER_S)
        if len(at) and at[0] < 0:
            raise DataRefused(self.path, None, f"t_s {columns[0][0]:.9g}", "times from 0 on in an MCAP file")
        rows = np.zeros(len(at), self._row)
        for i, (key, column) in enumerate(zip(self._keys, columns, strict=True)):
            rows[f"{i}k"], rows[f"{i}v"] = key, column
        size, content = self._row.itemsize, rows.tobytes()
        for i, now in enumerate(at.astype(np.int64).tolist()):
            self.add(self._channel, now, content[i * size : (i + 1) * size], self._count & 0xFFFFFFFF)
            self._count += 1

    def abandon(self) -> None:
        """Release the file."""
        self.let_go()


def _varint(number: int) -> bytes:
    found = b""
    while number > 0x7F:
        found += bytes([number & 0x7F | 0x80])
        number >>= 7
    return found + bytes([number])


IMU_TOPIC, TEMPERATURE_TOPIC = "/imu/data", "/imu/temperature"


class Ros2Samples:
    """Writes a bag; in m/s2 and rad/s, as ROS has them."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        try:
            from rosbags.rosbag2 import StoragePlugin, Writer
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            raise ExtraMissing("rosbags", "rosbags", "write .mcap") from None
        if not columns.is_si:
            raise DataRefused(path, None, "other units", "m/s2,rad/s in a ROS bag", "leave --units out")
        self._path, self._frame = path, columns.frame
        self._temperature = columns.names.index("temp_c") if "temp_c" in columns.names else None
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._writer: Any = Writer(path, version=8, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        names = {IMU_TOPIC: "sensor_msgs/msg/Imu", TEMPERATURE_TOPIC: "sensor_msgs/msg/Temperature"}
        if self._temperature is None:
            del names[TEMPERATURE_TOPIC]
        self._channels = {
            topic: self._writer.add_connection(topic, name, typestore=self._store) for topic, name in names.items()
        }

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, columns (n,) in m/s2 and rad/s."""
        types = self._store.types
        Imu, Header, Time = (
            types[name] for name in ("sensor_msgs/msg/Imu", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
        )
        Vector3, Quaternion = (types[f"geometry_msgs/msg/{name}"] for name in ("Vector3", "Quaternion"))
        unknown, absent = np.zeros(9), np.array([-1.0] + [0.0] * 8)
        at = np.rint(columns[0] * NS_PER_S).astype(np.int64)
        if len(at) and at[0] < 0:
            raise DataRefused(self._path, None, f"t_s {columns[0][0]:.9g}", "times from 0 on in a ROS bag")
        rows = np.stack(columns, axis=1).tolist()
        for now, row in zip(at.tolist(), rows, strict=True):
            header = Header(Time(now // 10**9, now % 10**9), self._frame)
            force, rate = Vector3(*row[1:4]), Vector3(*row[4:7])
            of_force, of_rate = (unknown if isfinite(row[i]) else absent for i in (1, 4))
            message = Imu(header, Quaternion(0.0, 0.0, 0.0, 1.0), absent, rate, of_rate, force, of_force)
            self._add(IMU_TOPIC, now, message)
            if self._temperature is not None and np.isfinite(row[self._temperature]):
                temperature = types["sensor_msgs/msg/Temperature"](header, row[self._temperature], 0.0)
                self._add(TEMPERATURE_TOPIC, now, temperature)

    def _add(self, topic: str, now: int, message: Any) -> None:
        channel = self._channels[topic]
        self._writer.write(channel, now, self._store.serialize_cdr(message, channel.msgtype))

    def finish(self) -> None:
        """Put the bag on the disk."""
        self._writer.close()
        for file in self._path.iterdir():
            with file.open("rb") as stream:
                sync_file(stream)
        sync_folder(self._path)

    def abandon(self) -> None:
        """Release the bag."""
        self._writer.close()


WRITERS: Mapping[str, Callable[[Path, SampleColumns], SampleWriter]] = MappingProxyType({
    ".csv": CsvSamples,
    ".parquet": ParquetSamples,
    ".mcap": McapSamples,
    ".npz": NpzSamples,
    ".mat": MatSamples,
    ".ros2": Ros2Samples,
})  # fmt: skip
"""By the suffix of what is asked for."""


def writer_for(path: Path) -> Callable[[Path, SampleColumns], SampleWriter]:
    """Return what writes a file of this suffix; raise `DataRefused` where nothing does."""
    if (writer := WRITERS.get(path.suffix.lower())) is None:
        found = f"suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise DataRefused(path, None, found, f"one of {', '.join(WRITERS)}", "name the file so")
    return writer
