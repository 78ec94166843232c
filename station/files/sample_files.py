"""Calibrated samples as files: one line in `WRITERS` for each format; MCAP and ROS 2 bags are here."""

import os
from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from fixtures_db.folder_on_disk import sync_folder
from procedures.arrays import FloatArray
from procedures.optional_libraries import ExtraMissing
from station.errors import DataRefused
from station.files.mcap_files.schemas import SAMPLE, TOPIC, built, numbered, sample_message
from station.files.mcap_files.writer import new_channel, new_file
from station.files.sample_arrays import (
    NS_PER_S,
    CsvSamples,
    MatSamples,
    NpzSamples,
    ParquetSamples,
    SampleColumns,
    SampleWriter,
)

WIRE_64 = 1  # the wire type of doubles


class McapSamples:
    """Writes MCAP; the log time is ``t_s`` in ns. A message has all columns, nan where one is not known."""

    def __init__(self, path: Path, columns: SampleColumns) -> None:
        self._path = path
        self._stream, self._writer = new_file(path)
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
            raise DataRefused(self._path, None, f"t_s {columns[0][0]:.9g}", "times from 0 on in an MCAP file")
        rows = np.zeros(len(at), self._row)
        for i, (key, column) in enumerate(zip(self._keys, columns, strict=True)):
            rows[f"{i}k"], rows[f"{i}v"] = key, column
        size, content = self._row.itemsize, rows.tobytes()
        for i, now in enumerate(at.astype(np.int64).tolist()):
            data = content[i * size : (i + 1) * size]
            self._writer.add_message(self._channel, now, data, publish_time=now, sequence=self._count & 0xFFFFFFFF)
            self._count += 1

    def finish(self) -> None:
        """Put the file on the disk."""
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._stream.close()

    def abandon(self) -> None:
        """Release the file."""
        self._stream.close()


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
                os.fsync(stream.fileno())
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
