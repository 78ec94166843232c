"""What the reader process tells the station, and its bytes on the pipe between them."""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

from drivers import errors
from drivers.errors import DriverError
from station.errors import CannotWrite, DiskFull

HEAD = struct.Struct("<BqI")  # kind, host_ns, length of what follows
LOST = "port lost: "  # what a gap mark's reason begins with where the port went


class Kind(IntEnum):
    """The kinds of message."""

    OPENED = 1
    CHUNK = 2
    GAP = 3
    REFUSED = 4  # by the port; the last message
    NOT_WRITTEN = 5  # by the journal; the last message
    QUIET = 6  # nothing has come until now


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes as one read returned them, and when [ns]: monotonic, counted from the epoch."""

    host_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class GapMark:
    """Bytes may be missing here; ``is_open`` says whether the port is open now [ns as in `Chunk`]."""

    host_ns: int
    reason: str
    is_open: bool


Item = Chunk | GapMark


def packed(kind: Kind, host_ns: int, content: bytes) -> bytes:
    """Return a message as bytes."""
    return HEAD.pack(kind, host_ns, len(content)) + content


def packed_gap(mark: GapMark) -> bytes:
    """Return a gap mark as a message."""
    return packed(Kind.GAP, mark.host_ns, json.dumps([mark.reason, mark.is_open]).encode())


def packed_refusal(host_ns: int, error: DriverError) -> bytes:
    """Return a port's refusal as a message: its kind, text and data."""
    told = {"kind": type(error).__name__, "text": str(error), "data": _plain(vars(error))}
    return packed(Kind.REFUSED, host_ns, json.dumps(told).encode())


def packed_not_written(host_ns: int, error: CannotWrite) -> bytes:
    """Return the journal's failure as a message."""
    told = {"is_full": isinstance(error, DiskFull), "path": error.path, "reason": error.reason}
    return packed(Kind.NOT_WRITTEN, host_ns, json.dumps(told).encode())


def unpacked(buffer: bytearray) -> Iterator[tuple[Kind, int, bytes]]:
    """Yield the whole messages at the front of ``buffer`` and take them off."""
    at = 0
    while len(buffer) - at >= HEAD.size:
        kind, host_ns, length = HEAD.unpack_from(buffer, at)
        if len(buffer) - at < HEAD.size + length:
            break
        yield Kind(kind), host_ns, bytes(buffer[at + HEAD.size : at + HEAD.size + length])
        at += HEAD.size + length
    del buffer[:at]


def item(kind: Kind, host_ns: int, content: bytes) -> Item:
    """Return a chunk or a gap mark from its message."""
    if kind is Kind.CHUNK:
        return Chunk(host_ns, content)
    reason, is_open = json.loads(content)
    return GapMark(host_ns, reason, is_open)


def refusal(kind: Kind, content: bytes) -> DriverError | CannotWrite:
    """Return the error that the reader process met, as it was there."""
    told = json.loads(content)
    if kind is Kind.NOT_WRITTEN:
        return DiskFull(told["path"]) if told["is_full"] else CannotWrite(told["path"], told["reason"])
    error_type: type[DriverError] = getattr(errors, told["kind"])
    error = error_type.__new__(error_type)
    BaseException.__init__(error, told["text"])  # its own constructor would make the text again
    for name, value in told["data"].items():
        setattr(error, name, value)
    return error


def _plain(data: dict[str, object]) -> dict[str, object]:
    return {name: value for name, value in data.items() if isinstance(value, str | int | float | None)}
