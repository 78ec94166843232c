"""Writing a new MCAP file: chunked, compressed, with checksums, readable after a kill; none is overwritten.

`StepWriter` writes one step: counts and raw bytes.
"""

import contextlib
import hashlib
import os
from collections.abc import Collection
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.writer import CompressionType, Writer

from fixtures_db.folder_on_disk import sync_folder
from procedures.counts.sample_records import SampleBlock
from station.errors import cannot_write
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC, MESSAGES, RAW, RAW_TOPIC, SCHEMA


def new_file(path: Path) -> tuple[BinaryIO, Writer]:
    """Return a new file and what writes into it; raise `CannotWrite` if it is there or cannot be made."""
    try:
        stream = path.open("xb")
    except OSError as error:
        raise cannot_write(path, error) from error
    writer = Writer(stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
    writer.start(profile="", library="station")
    return stream, writer


def new_channel(writer: Writer, topic: str, message: str, schema: bytes) -> int:
    """Return the number of a new channel of protobuf messages; ``schema`` describes them."""
    known = writer.register_schema(name=message, encoding="protobuf", data=schema)
    return writer.register_channel(topic=topic, message_encoding="protobuf", schema_id=known)


GAP = "station.gap"


class GrowingFile:
    """A new file; what was flushed survives a kill, a file is never overwritten."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stream, self._writer = new_file(path)
        self._is_named = False  # its name is on the disk

    def add(self, channel: int, host_ns: int, content: bytes, sequence: int = 0) -> None:
        """Add a message of a moment [ns since the epoch]."""
        self._writer.add_message(channel, host_ns, content, publish_time=host_ns, sequence=sequence)

    def add_gap(self, host_ns: int, reason: str, *, is_open: bool) -> None:
        """Note that something may be missing from here on, as a metadata record."""
        metadata = {"host_ns": str(host_ns), "reason": reason, "is_open": str(is_open).lower()}
        self._writer.add_metadata(GAP, metadata)

    def flush(self, *, sync: bool = True) -> None:
        """Close the chunk in progress and hand it to the system; with ``sync`` also to the disk."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        if sync:
            os.fsync(self._stream.fileno())
            if not self._is_named:
                sync_folder(self.path.parent)
                self._is_named = True

    def finish(self, *, data_first: bool = True) -> None:
        """Finish the file on the disk; a second call changes nothing.

        With ``data_first`` the data are there before the end: a file that has its end has all of them.
        """
        if self._stream.closed:
            return
        try:
            if data_first:
                self.flush()
            self._writer.finish()  # type: ignore[no-untyped-call]
            self.flush()
        finally:
            self._stream.close()

    def let_go(self) -> None:
        """Close the file where it cannot be finished; what is left to write is tried once more."""
        with contextlib.suppress(OSError):
            self._stream.close()


_WORD = 0xFFFFFFFF


class StepWriter(GrowingFile):
    """Writes a step's file. Call `flush` every 0.1 to 0.25 s while recording and `close` when it is accepted.

    ``output`` is the message of ``/imu/counts``: counts, or rates of an IMU that reports a value in a linear unit.
    """

    def __init__(self, path: Path, output: str = COUNTS) -> None:
        super().__init__(path)
        self._sample, self._raw = MESSAGES[output], MESSAGES[RAW]
        self._counts = new_channel(self._writer, COUNTS_TOPIC, output, SCHEMA)
        self._bytes = new_channel(self._writer, RAW_TOPIC, RAW, SCHEMA)
        self.samples = 0

    def write_raw(self, host_ns: int, data: bytes) -> None:
        """Write bytes as they were read from the port; ``host_ns`` is when, in ns since the epoch."""
        self.add(self._bytes, host_ns, self._raw(data=data, host_ns=host_ns).SerializeToString())

    def write_block(
        self,
        host_ns: int,
        block: SampleBlock,
        triads: Collection[str] = ("gyro", "accel"),
        utc_s: float | None = None,
    ) -> None:
        """Write decoded frames, a message each; the device's time must be known [s].

        A triad that is not among ``triads`` is absent: the device does not measure it. ``utc_s`` [s since 1970] is
        reference time at ``host_ns``: of the last frame, the one that came then.
        """
        if not np.isfinite(block.device_time).all():
            raise ValueError("device_time is nan: give each frame its time before it is recorded")
        columns = (
            np.rint(block.device_time * 1e9).astype(np.int64),
            *(getattr(block, name) if name in triads else np.empty((len(block), 0)) for name in ("gyro", "accel")),
            block.temperature,
            np.maximum(block.counter, 0) & _WORD,
            block.status & _WORD,
        )
        last = len(block) - 1
        rows = zip(*(column.tolist() for column in columns), strict=True)
        for row, (device, gyro, accel, celsius, count, word) in enumerate(rows):
            sample = self._sample(
                device_ns=device, host_ns=host_ns, gyro=gyro, accel=accel, temperature_c=celsius, counter=count,
                status=word, aux={} if utc_s is None or row < last else {"utc_s": utc_s},
            )  # fmt: skip
            self.add(self._counts, host_ns, sample.SerializeToString(), count)
        self.samples += len(block)

    def close(self) -> str:
        """Finish the file on disk and return its sha256; a second call changes nothing."""
        self.finish(data_first=self._is_named)
        with self.path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()

    def abandon(self) -> None:
        """Let the file go and take it away, where it cannot be finished."""
        self.let_go()
        self.path.unlink(missing_ok=True)
