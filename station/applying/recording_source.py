"""Samples of an MCAP recording: messages of ``/imu/counts``, or the raw bytes of a device decoded again."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.errors import ReplayEnded
from procedures.arrays import FloatArray
from procedures.counts.sample_records import SampleBlock
from procedures.frames import TRIADS
from station.applying.source import Samples, Stated, channels_by_column
from station.errors import DataRefused
from station.files.mcap_files.reader import sample_messages, topic_messages
from station.files.mcap_files.schemas import COUNTS, MESSAGES, RAW, RAW_TOPIC
from station.files.opening import unreadable
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.reader import Chunk
from station.stream.reader.messages import StreamGap

BLOCK = 2**13


@dataclass(frozen=True, slots=True, eq=False)
class RecordingSource:
    """A recording, or a step's file of a campaign."""

    file: Path
    stated: Stated
    channels: tuple[str, ...]

    @classmethod
    def open(cls, file: Path, stated: Stated) -> "RecordingSource":
        """Open an MCAP file; ``stated`` is what its campaign says.

        Raise `DataRefused` if it cannot be read, or holds no sample.
        """
        try:
            found = _looked_through(file)
        except OSError as error:
            raise unreadable(file, error) from None
        if stated.output is not None and (stated.output == "rate") != (found.output == "rate"):
            raise DataRefused(file, None, f"{found.output} messages", f"{stated.output}, as imu.output says")
        triads = tuple(name for name in TRIADS if name in found.triads)
        auxiliary = channels_by_column(sorted(found.channels - {"utc_s"}), str(file))
        text = replace(
            stated, name=str(file), output=stated.output or found.output, temperature=found.temperature,
            auxiliary=tuple(auxiliary), triads=triads, damage=" ".join(found.damage),
        )  # fmt: skip
        return cls(file, text, tuple(auxiliary.values()))

    def blocks(self) -> Generator[Samples]:
        """Yield all samples, as `Source`."""
        for part, first in _parts(self.file):
            samples = [message for message, _ in part]
            values = np.hstack([_triad(samples, name) for name in ("gyro", "accel")])
            temperature = (
                np.array([message.temperature_c for message in samples]) if self.stated.temperature else None
            )
            auxiliary = {
                key: np.array([message.aux.get(name, np.nan) for message in samples])
                for key, name in zip(self.stated.auxiliary, self.channels, strict=True)
            }
            t = np.array([message.device_ns for message in samples]) / 1e9
            lines = range(first, first + len(part))
            yield Samples(t, values, temperature, auxiliary, part[-1][1], self.stated.name, lines)


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


TRIAD_WORDS = {"gyroscope": "gyro", "accelerometer": "accel"}


@dataclass(frozen=True, slots=True)
class RawSource:
    """A file of bytes that make so many ``samples``; ``stated`` is what the device says of itself."""

    file: Path
    stated: Stated
    samples: int

    @classmethod
    def open(cls, file: Path, stated: Stated) -> "RawSource":
        """Open an MCAP file of bytes.

        Raise `DataRefused` or `DriverError` if it cannot be read, or its bytes are of no known format.
        """
        feed = _identified(file, stated)
        assert feed.unit is not None
        kind, output = feed.stream.decoder.kind, "increments" if feed.wire.output == "increments" else "rate"
        triads = tuple(name for name in ("accelerometer", "gyroscope") if TRIAD_WORDS[name] in kind.triads)
        text = replace(
            stated, name=str(file), output=output, model=stated.model or feed.unit.model,
            serial=stated.serial or feed.unit.serial, triads=triads,
        )  # fmt: skip
        warm, samples, damage = False, 0, list[str]()
        for block, _ in _blocks(file, text, damage.append):
            warm, samples = warm or bool(np.isfinite(block.temperature).any()), samples + len(block)
        return cls(file, replace(text, temperature=warm, damage=" ".join(damage)), samples)

    def blocks(self) -> Generator[Samples]:
        """Yield all samples, as `Source`."""
        for block, first in _blocks(self.file, self.stated):
            n = len(block)
            values = np.hstack([
                getattr(block, short).astype(np.float64) if name in self.stated.triads else np.full((n, 3), np.nan)
                for name, short in TRIAD_WORDS.items()
            ])  # fmt: skip
            temperature = block.temperature if self.stated.temperature else None
            yield Samples(
                block.device_time, values, temperature, {}, 0.0, self.stated.name, range(first, first + n)
            )


class _FileChunks:
    """The bytes of a file as a feed takes them, a chunk after the other."""

    def __init__(self, file: Path, *cut: Callable[[str], None]) -> None:
        self.address: DeviceAddress = parse_device_url(f"replay:{file}")
        self._size, kind = 0, MESSAGES[RAW]
        self._messages = topic_messages(file, {RAW_TOPIC: kind.FromString}, *cut)

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return the next chunk; raise `ReplayEnded` after the last."""
        if (message := next(self._messages, None)) is None:
            raise ReplayEnded(self.address.name, self._size)
        self._size += len(message.data)
        return [Chunk(int(message.host_ns), bytes(message.data))]


def _identified(file: Path, stated: Stated, *cut: Callable[[str], None]) -> LiveFeed:
    try:
        feed = open_feed(_FileChunks(file, *cut))
    except OSError as error:
        raise unreadable(file, error) from None
    feed.identify_or_unknown(stated.model, stated.serial)
    return feed


def _blocks(file: Path, stated: Stated, *cut: Callable[[str], None]) -> Generator[tuple[SampleBlock, int]]:
    """Yield blocks of samples with the first one's number, from 1 on."""
    feed, is_over = _identified(file, stated, *cut), False
    buffer = feed.buffer
    at = begin = buffer.first
    while not is_over:
        try:
            feed.advance()
        except ReplayEnded:
            is_over = True
        at = max(at, buffer.first)
        if buffer.end - at >= BLOCK or (is_over and buffer.end > at):
            yield buffer.block(at, buffer.end), at - begin + 1
            at = buffer.end
            buffer.forget_before(at)
