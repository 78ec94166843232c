"""Reading an MCAP file, of a step or of some topics: every chunk checked, a file cut short read as far as it goes.

What the checksums or the format contradict is refused; only an end that comes too early is forgiven, and reported.
"""

import hashlib
import struct
from collections.abc import Callable, Generator, Mapping
from io import BufferedReader
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import zstandard
from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.records import Channel, Schema

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.mcap_files.messages import Messages, StepContents
from station.files.mcap_files.records import CutShort, Message, file_records
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC, MESSAGES
from station.files.tables.strict_csv import MAX_EXACT_INTEGER, TRIADS
from station.files.tables.table import Table

T = TypeVar("T")
DAMAGE = (
    McapError, DecodeError, zstandard.ZstdError, struct.error, ValueError, KeyError, OverflowError, MemoryError,
)  # fmt: skip


def read_step(path: Path) -> StepContents:
    """Read a step's file by its path, see `read_stream`."""
    with path.open("rb") as stream:
        return read_stream(stream, path)


def read_stream(stream: BufferedReader, file: Path) -> StepContents:
    """Read the samples and raw bytes of a step; ``damage`` says so where the file ends too early.

    Raise `DataRefused` if a checksum, a record or a message is wrong, or messages are missing from a complete
    file.
    """
    sha256 = hashlib.file_digest(stream, "sha256").hexdigest()
    stream.seek(0)
    messages, damage = Messages(), None
    try:
        try:
            for record in file_records(stream):
                messages.add(record)
            messages.check_complete()
        except CutShort as error:
            damage = str(error)
        return messages.contents(sha256, damage)
    except DAMAGE as error:
        found = f"damage after message {messages.total} ({_short(error)})"
        raise DataRefused(file, None, found, "an intact MCAP file with messages of campaign/1") from error


def _unheard(damage: str) -> None:
    """Take what is wrong with the end of a file where nobody asks for it."""


def topic_messages(
    path: Path, kinds: Mapping[str, Callable[[bytes], T]], cut: Callable[[str], None] = _unheard
) -> Generator[T]:
    """Yield each message of the topics in ``kinds``, as these read it; a file cut short goes as far as it goes.

    ``cut`` is called with a description of an end that comes too early. Raise `DataRefused` if a checksum, a
    record or a message is wrong.
    """
    topics, count = dict[int, str](), 0
    try:
        with path.open("rb") as stream:
            for record in file_records(stream):
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message) and topics[record.channel_id] in kinds:
                    yield kinds[topics[record.channel_id]](record.data)
                    count += 1
    except CutShort as error:
        cut(str(error))
    except DAMAGE as error:
        raise DataRefused(
            path, None, f"damage after record {count} ({_short(error)})", "an intact file"
        ) from error


def sample_messages(path: Path, cut: Callable[[str], None] = _unheard) -> Generator[tuple[Any, float]]:
    """Yield each message of ``/imu/counts``, and the share of the file that has been read with it.

    ``cut`` is called with a description of an end that comes too early. Raise `DataRefused` if a checksum, a
    record or a message is wrong; an end that comes too early is the end.
    """
    schemas, parsers, count = dict[int, str](), dict[int, Any](), 0
    size = max(path.stat().st_size, 1)
    try:
        with path.open("rb") as stream:
            for record in file_records(stream):
                if isinstance(record, Schema):
                    schemas[record.id] = record.name
                elif isinstance(record, Channel) and record.topic == COUNTS_TOPIC:
                    parsers[record.id] = MESSAGES[schemas[record.schema_id]]
                elif isinstance(record, Message) and record.channel_id in parsers:
                    yield parsers[record.channel_id].FromString(record.data), stream.tell() / size
                    count += 1
    except CutShort as error:
        cut(str(error))
    except DAMAGE as error:
        found = f"damage after sample {count} ({_short(error)})"
        raise DataRefused(path, None, found, "an intact recording of the station") from error


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__


def read_table(stream: BufferedReader, file: Path, *, counts: bool) -> Table:
    """Read a step's file as columns; a line of the table is a message of ``/imu/counts``.

    Raise `DataRefused` if the file is damaged, holds no sample, or rates where counts are reported, or the other
    way round.
    """
    step = read_stream(stream, file)
    if not len(step):
        raise DataRefused(file, None, f"no message on {COUNTS_TOPIC}", "one message per sample")
    if (step.output == COUNTS) != counts:
        raise DataRefused(
            file, None, f"{step.output} messages", f"messages as imu.output says: counts is {counts}"
        )
    columns: dict[str, FloatArray] = {"t_s": step.device_ns / 1e9}
    for triad, names in TRIADS.items():
        values = getattr(step, triad)
        if values is not None:
            _check_range(values, file, triad, counts=counts)
            columns |= {name: values[:, i].astype(float) for i, name in enumerate(names)}
    if len(columns) == 1:
        raise DataRefused(file, 1, "neither gyro nor accel", "at least one triad")
    columns["temp_c"] = np.where(np.isfinite(step.temperature), step.temperature, np.nan)
    for name, values in step.aux.items():
        columns[name if name == "utc_s" or name.startswith("aux_") else f"aux_{name}"] = values
    first, last = int(step.host_ns.min()), int(step.host_ns.max())
    return Table(
        file, columns, step.sha256, range(1, 1 + len(step.device_ns)),
        host_span=(first, last) if first > 0 else None, damage=step.damage,
    )  # fmt: skip


def _check_range(values: FloatArray, file: Path, triad: str, *, counts: bool) -> None:
    bad = (values >= MAX_EXACT_INTEGER) | (values <= -MAX_EXACT_INTEGER) if counts else ~np.isfinite(values)
    if len(rows := np.flatnonzero(bad.any(axis=1))):
        wanted = "counts below 2^53" if counts else "finite numbers"
        raise DataRefused(file, int(rows[0]) + 1, f"{triad} {values[rows[0]].tolist()}", wanted)
