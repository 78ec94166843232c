"""Samples of bytes as a device sent them: what `station stream --folder` keeps, decoded again."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.errors import ReplayEnded
from procedures.campaign.campaign import UNKNOWN
from procedures.counts.sample_records import SampleBlock
from procedures.error_codes import ErrorCode
from station.applying.recording_source import BLOCK
from station.applying.source import Samples, Times, Told
from station.errors import DataRefused
from station.files.mcap_files.reader import topic_messages
from station.files.mcap_files.schemas import MESSAGES, RAW, RAW_TOPIC
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.reader import Chunk, GapMark

TRIADS = {"gyroscope": "gyro", "accelerometer": "accel"}


@dataclass(frozen=True, slots=True)
class RawSource:
    """A file of bytes that make so many ``samples``; ``told`` is what the device says of itself."""

    file: Path
    told: Told
    samples: int

    @classmethod
    def open(cls, file: Path, told: Told) -> "RawSource":
        """Open an MCAP file of bytes.

        Raises
        ------
        DataRefused, DriverError
            If it cannot be read, or its bytes are of no known format.
        """
        feed = _identified(file, told)
        assert feed.unit is not None
        kind, output = feed.stream.decoder.kind, "increments" if feed.wire.output == "increments" else "rate"
        triads = tuple(name for name in ("accelerometer", "gyroscope") if TRIADS[name] in kind.triads)
        said = replace(
            told, name=str(file), output=output, model=told.model or feed.unit.model,
            serial=told.serial or feed.unit.serial, triads=triads,
        )  # fmt: skip
        warm, samples, damage = False, 0, list[str]()
        for block, _ in _blocks(file, said, damage.append):
            warm, samples = warm or bool(np.isfinite(block.temperature).any()), samples + len(block)
        return cls(file, replace(said, temperature=warm, damage=" ".join(damage)), samples)

    def times(self) -> Generator[Times]:
        """Yield the times (n,) [s] of all samples, as `Source`."""
        for block, first in _blocks(self.file, self.told):
            yield block.device_time, self.told.name, range(first, first + len(block))

    def blocks(self) -> Generator[Samples]:
        """Yield all samples, as `Source`."""
        for block, first in _blocks(self.file, self.told):
            n = len(block)
            values = np.hstack([
                getattr(block, short).astype(np.float64) if name in self.told.triads else np.full((n, 3), np.nan)
                for name, short in TRIADS.items()
            ])  # fmt: skip
            temperature = block.temperature if self.told.temperature else None
            yield Samples(block.device_time, values, temperature, {}, 0.0, self.told.name, range(first, first + n))


class _FileChunks:
    """The bytes of a file as a feed takes them, a chunk after the other."""

    def __init__(self, file: Path, *cut: Callable[[str], None]) -> None:
        self.address: DeviceAddress = parse_device_url(f"replay:{file}")
        self._size, kind = 0, MESSAGES[RAW]
        self._messages = topic_messages(file, {RAW_TOPIC: kind.FromString}, *cut)

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        """Return the next chunk; raise `ReplayEnded` after the last."""
        if (message := next(self._messages, None)) is None:
            raise ReplayEnded(self.address.name, self._size)
        self._size += len(message.data)
        return [Chunk(int(message.host_ns), bytes(message.data))]


def _identified(file: Path, told: Told, *cut: Callable[[str], None]) -> LiveFeed:
    try:
        feed = open_feed(_FileChunks(file, *cut))
    except OSError as error:
        raise DataRefused(
            file, None, (error.strerror or str(error)).lower(), "a readable file", code=ErrorCode.FILE_MISSING
        ) from None
    unknown = UNKNOWN if feed.wire.identity is None else None
    feed.identify(told.model or unknown, told.serial or unknown)
    return feed


def _blocks(file: Path, told: Told, *cut: Callable[[str], None]) -> Generator[tuple[SampleBlock, int]]:
    """Yield blocks of samples with the first one's number, from 1 on."""
    feed, is_over = _identified(file, told, *cut), False
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
