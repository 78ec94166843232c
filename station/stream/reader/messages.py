"""Messages from the reader process to the station, their bytes on the pipe between them, and who sends them."""

import os
import pickle
import struct
import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from drivers.errors import DriverError
from station.errors import CannotWrite

HEAD = struct.Struct("<I")  # length of what follows
MAX_WAITING_BYTES = 64 * 2**20  # bytes: an hour of 17 kB/s; the recording has it all
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
    """What port or recording refused, in its parts; the last message."""

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


class Outbox:
    """Sends messages in order over a pipe on its own thread; beyond `MAX_WAITING_BYTES` it refuses."""

    def __init__(self, descriptor: int, limit: int = MAX_WAITING_BYTES) -> None:
        self._descriptor, self._limit = descriptor, limit
        self._messages: deque[bytes] = deque()
        self._waiting = 0
        self._changed = threading.Condition()
        self._is_closed = self._is_deaf = False
        self._thread = threading.Thread(target=self._run, name="outbox", daemon=True)
        self._thread.start()

    def put(self, message: bytes, *, always: bool = False) -> bool:
        """Queue a message and return at once; False if there is no room, unless it goes ``always``."""
        with self._changed:
            if self._waiting > self._limit and not always:
                return False
            self._messages.append(message)
            self._waiting += len(message)
            self._changed.notify_all()
            return True

    def wait_for_room(self, timeout_s: float) -> None:
        """Wait until half the room is free again, at most ``timeout_s``."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting < self._limit / 2 or self._is_deaf, timeout_s)

    def close(self, timeout_s: float) -> None:
        """Send what is queued, for at most ``timeout_s``."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._messages or self._is_closed)
                if not self._messages:
                    return
                batch = b"".join(self._messages)
                self._messages.clear()
            if not self._send(batch):
                return

    def _send(self, batch: bytes) -> bool:
        view = memoryview(batch)
        while view:
            try:
                sent = os.write(self._descriptor, view[:65536])
            except OSError:  # the station is gone: its pipe is closed
                with self._changed:
                    self._is_deaf, self._waiting = True, 0
                    self._changed.notify_all()
                return False
            view = view[sent:]
            with self._changed:
                self._waiting -= sent
                self._changed.notify_all()
        return True
