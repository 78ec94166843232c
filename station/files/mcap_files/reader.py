"""Reading an MCAP file, of a step or of some topics: every chunk checked, a file cut short read as far as it goes.

What the checksums or the format contradict is refused; only an end that comes too early is forgiven, and said.
"""

import hashlib
import struct
from collections.abc import Callable, Generator, Mapping
from io import BufferedReader
from pathlib import Path
from typing import Any, TypeVar

import zstandard
from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.records import Channel, Schema

from station.errors import DataRefused
from station.files.mcap_files.messages import Messages, StepContents
from station.files.mcap_files.records import CutShort, Message, file_records
from station.files.mcap_files.schemas import COUNTS_TOPIC, MESSAGES

T = TypeVar("T")
DAMAGE = (
    McapError,
    DecodeError,
    zstandard.ZstdError,
    struct.error,
    ValueError,
    KeyError,
    OverflowError,
    MemoryError,
)


def read_step(path: Path) -> StepContents:
    """Read a step's file by its path, see `read_stream`."""
    with path.open("rb") as stream:
        return read_stream(stream, path)


def read_stream(stream: BufferedReader, file: Path) -> StepContents:
    """Read the samples and raw bytes of a step; ``damage`` says so where the file ends too early.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong, or messages are missing from a complete file.
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

    ``cut`` is told of an end that comes too early.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong.
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

    ``cut`` is told of an end that comes too early.

    Raises
    ------
    DataRefused
        If a checksum, a record or a message is wrong; an end that comes too early is the end.
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
