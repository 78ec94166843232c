"""Samples of an MCAP file that the station recorded: ``/imu/counts``, a message after the other."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from procedures.frames import TRIADS
from station.applying.channel_columns import channels_by_column
from station.applying.source import Samples, Times, Told
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
            found = _looked_through(file)
        except OSError as error:
            raise DataRefused(
                file, None, (error.strerror or str(error)).lower(), "a readable file", code=ErrorCode.FILE_MISSING
            ) from None
        if told.output is not None and (told.output == "rate") != (found.output == "rate"):
            raise DataRefused(file, None, f"{found.output} messages", f"{told.output}, as imu.output says")
        triads = tuple(name for name in TRIADS if name in found.triads)
        beside = channels_by_column(sorted(found.channels - {"utc_s"}), str(file))
        said = replace(
            told, name=str(file), output=told.output or found.output, temperature=found.temperature,
            auxiliary=tuple(beside), triads=triads, damage=" ".join(found.damage),
        )  # fmt: skip
        return cls(file, said, tuple(beside.values()))

    def times(self) -> Generator[Times]:
        """Yield the times (n,) [s] of all samples, as `Source`."""
        for part, first in _parts(self.file):
            t = np.array([message.device_ns for message, _ in part]) / 1e9
            yield t, self.told.name, range(first, first + len(part))

    def blocks(self) -> Generator[Samples]:
        """Yield all samples, as `Source`."""
        for part, first in _parts(self.file):
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
            lines = range(first, first + len(part))
            yield Samples(t, values, temperature, beside, part[-1][1], self.told.name, lines)


@dataclass(slots=True)
class _Found:
    """What the messages of a recording hold, any of them."""

    output: str = ""
    temperature: bool = False
    triads: set[str] = field(default_factory=set)
    channels: set[str] = field(default_factory=set)
    damage: list[str] = field(default_factory=list)


def _looked_through(file: Path) -> _Found:
    """Look at every message: what begins late, as a channel of a thermometer, is there too."""
    found = _Found()
    for part, _ in _parts(file, found.damage.append):
        messages = [message for message, _ in part]
        found.output = "increments" if messages[0].DESCRIPTOR.full_name == COUNTS else "rate"
        found.temperature = found.temperature or any(np.isfinite(each.temperature_c) for each in messages)
        for triad, name in (("accelerometer", "accel"), ("gyroscope", "gyro")):
            if triad not in found.triads and any(getattr(each, name) for each in messages):
                found.triads.add(triad)
        found.channels.update(name for each in messages for name in each.aux)
    if not found.output:
        raise DataRefused(file, None, "no message on /imu/counts", "one message per sample", "name another file")
    return found


def _parts(file: Path, *cut: Callable[[str], None]) -> Generator[tuple[list[tuple[Any, float]], int]]:
    """Yield messages with the share of the file that has been read, and the first one's number."""
    messages, first = sample_messages(file, *cut), 1
    while part := list(islice(messages, BLOCK)):
        yield part, first
        first += len(part)


def _triad(samples: list[Any], name: str) -> FloatArray:
    rows = [getattr(message, name) for message in samples]
    if not any(len(row) == 3 for row in rows):
        return np.full((len(rows), 3), np.nan)
    absent = (np.nan,) * 3
    return np.array([row if len(row) == 3 else absent for row in rows], dtype=np.float64)
