"""Samples of an MCAP file that the station recorded: ``/imu/counts``, a message after the other."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station.applying.source import Samples, Told
from station.errors import DataRefused
from station.files.mcap_files.reader import sample_messages
from station.files.mcap_files.schemas import COUNTS

BLOCK = 2**13


@dataclass(frozen=True, slots=True, eq=False)
class RecordingSource:
    """A recording, or a step's file of a campaign."""

    file: Path
    told: Told
    channels: tuple[str, ...]

    @classmethod
    def open(cls, file: Path, told: Told) -> "RecordingSource":
        """Open an MCAP file; ``told`` is what its campaign says.

        Raises
        ------
        DataRefused
            If it cannot be read, or holds no sample.
        """
        try:
            head = list(islice(sample_messages(file), BLOCK))
        except OSError as error:
            raise DataRefused(file, None, (error.strerror or str(error)).lower(), "a readable file") from None
        if not head:
            raise DataRefused(
                file, None, "no message on /imu/counts", "one message per sample", "name another file"
            )
        names = sorted({name for message, _ in head for name in message.aux})
        keys = tuple(name if name.startswith("aux_") else f"aux_{name}" for name in names if name != "utc_s")
        output = "increments" if head[0][0].DESCRIPTOR.full_name == COUNTS else "rate"
        if told.output is not None and (told.output == "rate") != (output == "rate"):
            raise DataRefused(file, None, f"{output} messages", f"{told.output}, as imu.output says")
        warm = any(np.isfinite(message.temperature_c) for message, _ in head)
        there = {"accelerometer": any(m.accel for m, _ in head), "gyroscope": any(m.gyro for m, _ in head)}
        triads = tuple(name for name, is_there in there.items() if is_there)
        said = replace(
            told, name=str(file), output=told.output or output, temperature=warm, auxiliary=keys, triads=triads
        )
        return cls(file, said, tuple(name for name in names if name != "utc_s"))

    def times(self) -> Iterator[tuple[FloatArray, str, int | None]]:
        """Yield the times (n,) [s] of all samples, as `Source`."""
        messages, first = sample_messages(self.file), 1
        while part := list(islice(messages, BLOCK)):
            yield np.array([message.device_ns for message, _ in part]) / 1e9, self.told.name, first
            first += len(part)

    def blocks(self) -> Iterator[Samples]:
        """Yield all samples, as `Source`."""
        messages, first = sample_messages(self.file), 1
        while part := list(islice(messages, BLOCK)):
            samples = [message for message, _ in part]
            values = np.hstack([_triad(samples, name) for name in ("gyro", "accel")])
            temperature = (
                np.array([message.temperature_c for message in samples]) if self.told.temperature else None
            )
            beside = {
                key: np.array([message.aux.get(name, np.nan) for message in samples])
                for key, name in zip(self.told.auxiliary, self.channels, strict=True)
            }
            t = np.array([message.device_ns for message in samples]) / 1e9
            yield Samples(t, values, temperature, beside, part[-1][1], self.told.name, first)
            first += len(part)


def _triad(samples: list[Any], name: str) -> FloatArray:
    rows = [getattr(message, name) for message in samples]
    if not any(len(row) == 3 for row in rows):
        return np.full((len(rows), 3), np.nan)
    absent = (np.nan,) * 3
    return np.array([row if len(row) == 3 else absent for row in rows], dtype=np.float64)
