"""Samples as a ROS 2 bag, a folder: ``sensor_msgs/Imu`` on ``/imu/data``; needs the extra ``rosbags``.

``linear_acceleration`` is specific force, as REP 145 asks. ``orientation_covariance[0]`` is -1: there is none; so
is that of a triad where it is not there. A covariance of nought is an unknown one. Temperatures are
``sensor_msgs/Temperature`` on ``/imu/temperature``.
"""

import os
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from fixtures_db.folder_on_disk import sync_folder
from procedures.arrays import FloatArray
from procedures.optional_libraries import ExtraMissing
from station.errors import DataRefused
from station.files.sample_files.sample_file import NS_PER_S, SampleColumns

TOPIC, TEMPERATURE_TOPIC = "/imu/data", "/imu/temperature"


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
        names = {TOPIC: "sensor_msgs/msg/Imu", TEMPERATURE_TOPIC: "sensor_msgs/msg/Temperature"}
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
            self._add(TOPIC, now, message)
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
        """Let go of the bag."""
        self._writer.close()
