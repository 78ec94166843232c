"""Samples as MCAP: ``/imu/calibrated``, a protobuf message each with a double a column, as Foxglove plots them."""

import os
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.mcap_files.calibrated_sample import SAMPLE, TOPIC, numbered, sample_message
from station.files.mcap_files.new_file import new_channel, new_file
from station.files.mcap_files.schemas import built
from station.files.sample_files.sample_file import NS_PER_S, SampleColumns

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
        """Let go of the file."""
        self._stream.close()


def _varint(number: int) -> bytes:
    found = b""
    while number > 0x7F:
        found += bytes([number & 0x7F | 0x80])
        number >>= 7
    return found + bytes([number])
