"""Messages from the reader process to the station, and their bytes on the pipe between them."""

import pickle
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from drivers.errors import DriverError
from station.errors import CannotWrite

HEAD = struct.Struct("<I")  # length of what follows
LOST = "port lost: "  # what a gap mark's reason begins with where the port went


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes as one read returned them, and when [ns]: monotonic, counted from the epoch."""

    host_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class StreamGap:
    """Bytes may be missing here; ``is_open`` says whether the port is open now [ns as in `Chunk`]."""

    host_ns: int
    reason: str
    is_open: bool


@dataclass(frozen=True, slots=True)
class Quiet:
    """Nothing has come until now; the first says that the port is open [ns as in `Chunk`]."""

    host_ns: int


@dataclass(frozen=True, slots=True)
class Refusal:
    """What port or journal refused, in its parts; the last message."""

    kind: type[DriverError] | type[CannotWrite]
    text: str
    data: dict[str, object]

    @property
    def error(self) -> DriverError | CannotWrite:
        """The error as it was in the reader process."""
        error = self.kind.__new__(self.kind)
        BaseException.__init__(error, self.text)  # its own constructor would make the text again
        vars(error).update(self.data)
        return error


Item = Chunk | StreamGap
Message = Item | Quiet | Refusal


def packed(message: Message) -> bytes:
    """Return a message as bytes."""
    content = pickle.dumps(message)
    return HEAD.pack(len(content)) + content


def unpacked(buffer: bytearray) -> Iterator[Message]:
    """Yield the whole messages at the front of ``buffer`` and take them off."""
    at = 0
    while len(buffer) - at >= HEAD.size:
        begin = at + HEAD.size
        end = begin + HEAD.unpack_from(buffer, at)[0]
        if len(buffer) < end:
            break
        yield pickle.loads(memoryview(buffer)[begin:end])
        at = end
    del buffer[:at]
