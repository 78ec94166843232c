"""A byte stream to checked frames: survives any cut, noise and false sync; no I/O, bounded memory.

From a sync on, the bytes are a frame if kind, length and check agree. If not, the search goes on one byte
after that sync, so a frame that begins inside a falsely started one is still found. What is decided
depends on the bytes alone, never on how the stream was cut.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drivers.continuity import CounterWatch, TimeWatch
from drivers.wire import FORMATS, Identity, WireFormat
from procedures.arrays import IntArray
from procedures.records import CountBlock


@dataclass(slots=True)
class FrameCounters:
    """What a decoder met since it was made.

    ``frames`` IMU frames accepted, ``identities`` frames of identity alone, ``skipped_bytes`` in no accepted
    frame, ``bad_crc`` frames whose check failed, ``bad_length`` known kinds with another length than
    their own, ``counter_jumps`` breaks of the sample sequence (see `drivers.continuity`), ``bad_status`` accepted
    frames that the format reads as unhealthy. Where a sample takes several frames, ``frames`` are samples,
    ``incomplete`` those given up, ``late`` frames repeated or come after their sample, ``foreign`` those of
    somebody else, ``bus_errors`` what the bus reported of itself.
    """

    frames: int = 0
    identities: int = 0
    skipped_bytes: int = 0
    bad_crc: int = 0
    bad_length: int = 0
    counter_jumps: int = 0
    bad_status: int = 0
    incomplete: int = 0
    late: int = 0
    foreign: int = 0
    bus_errors: int = 0


class Decoder:
    """Turns a stream of bytes into `CountBlock`s, as they come.

    ``counters`` says what was met; ``identity``, ``model`` and ``serial`` who the device last said it is.
    ``edges`` (n, 2) says where the bytes of each sample of the last block begin and end, counted from the first
    byte that was then fed: a begin is negative where they began before.
    """

    def __init__(self, wire: WireFormat) -> None:
        self.wire = wire
        self.counters = FrameCounters()
        self.identity: Identity | None = None
        self._kinds = wire.kinds
        self._head = len(wire.imu.prefix)
        self._maimed = {_without_length(prefix, wire.length_at) for prefix in self._kinds}
        self._pending = b""
        self._runs: list[tuple[int, int]] = []  # where accepted frames stand in what is scanned
        self._joiner = wire.joiner(self.counters) if wire.joiner is not None else None
        self._fed = self._scanned = 0  # bytes of the stream so far, and of those what is decided
        self.edges: IntArray = np.zeros((0, 2), np.int64)
        self._watch = TimeWatch() if wire.counter_modulus is None else CounterWatch(wire.counter_modulus)

    @property
    def model(self) -> str | None:
        """The model that the device says it is, None while it has not said."""
        return (self.identity.model or None) if self.identity else None

    @property
    def serial(self) -> str | None:
        """The serial number that the device says it has, None while it has not said."""
        return (self.identity.serial or None) if self.identity else None

    def feed(self, data: bytes) -> CountBlock:
        """Return the frames that ``data`` completes, possibly none."""
        origin, self._fed = self._fed, self._fed + len(data)
        return self._decode(self._scan(self._pending + data, at_end=False), origin)

    def finish(self) -> CountBlock:
        """Return what the bytes still waiting hold when no more will come; the rest of them is skipped."""
        return self._decode(self._scan(self._pending, at_end=True), self._fed)

    def _scan(self, buffer: bytes, *, at_end: bool) -> bytes:
        """Take the IMU frames out of ``buffer``, end to end, and keep its undecided tail."""
        sync, head, size, total = self.wire.sync, self._head, self.wire.imu.size, len(buffer)
        view, runs = memoryview(buffer), list[memoryview]()
        self._runs.clear()
        start = self._scanned
        at = kept = 0  # where the search stands; bytes in accepted frames
        while (at := _next_sync(buffer, sync, at, at_end=at_end)) + head <= total:
            end = self._run(buffer, view, at)
            if end > at:
                runs.append(view[at:end])
                self._runs.append((at + start, end + start))
            else:
                end = self._other(buffer, at)
                if end > total and not at_end:
                    break
            if at < end <= total:
                kept += end - at
                at = end
            else:
                at += 1
        if at_end:
            at = total
        self.counters.skipped_bytes += at - kept
        self._pending = buffer[at:]
        self._scanned += at
        if runs and self.wire.identity is self.wire.imu:
            self._identify(runs[-1][-size:].tobytes())
        return b"".join(runs)

    def _run(self, buffer: bytes, view: memoryview, at: int) -> int:
        """Return where the intact IMU frames that stand end to end from ``at`` on stop."""
        prefix, size, is_intact = self.wire.imu.prefix, self.wire.imu.size, self.wire.is_intact
        last = len(buffer) - size
        while at <= last and buffer.startswith(prefix, at) and is_intact(view[at : at + size]):
            at += size
        return at

    def _other(self, buffer: bytes, at: int) -> int:
        """Return the end of the frame at ``at`` that is not an intact IMU frame; ``at`` if it is none."""
        head = buffer[at : at + self._head]
        kind = self._kinds.get(head)
        if kind is None:
            self.counters.bad_length += _without_length(head, self.wire.length_at) in self._maimed
            return at
        end = at + kind.size
        if end <= len(buffer):
            frame = buffer[at:end]
            if kind is self.wire.imu or not self.wire.is_intact(frame):
                self.counters.bad_crc += 1
                return at
            self.counters.identities += 1
            self._identify(frame)
        return end

    def _identify(self, frame: bytes) -> None:
        if self.wire.identify is not None:
            self.identity = self.wire.identify(frame)

    def _decode(self, frames: bytes, origin: int) -> CountBlock:
        rows, size = np.frombuffer(frames, self.wire.frame), self.wire.imu.size
        begins = np.concatenate([np.arange(at, end, size) for at, end in self._runs] or [np.arange(0)])
        if self._joiner is None:
            block, edges = self.wire.decode(rows), np.stack((begins, begins + size), axis=1)
        else:
            block, edges = self._joiner.take(rows, begins)
        self.edges = edges - origin
        if len(block):
            self.counters.frames += len(block)
            self.counters.bad_status += int(np.count_nonzero(~block.healthy))
            self.counters.counter_jumps += self._watch.jumps(block)
        return block


def _next_sync(buffer: bytes, sync: bytes, at: int, *, at_end: bool) -> int:
    """Return where the next sync begins, or what may yet become one; else the end of the buffer."""
    found = buffer.find(sync, at)
    if found >= 0:
        return found
    if not at_end:
        for size in range(min(len(sync) - 1, len(buffer) - at), 0, -1):
            if buffer.endswith(sync[:size]):
                return len(buffer) - size
    return len(buffer)


def _without_length(prefix: bytes, length_at: int) -> bytes:
    return prefix[:length_at] + prefix[length_at + 1 :]


class Likeness(NamedTuple):
    """How much of some bytes is frames of a format."""

    format: str
    frames: int
    share_of_bytes: float


def sniff(data: bytes) -> list[Likeness]:
    """Return every format of which ``data`` holds frames, the one that explains most bytes first."""
    found = []
    for name, wire in FORMATS.items():
        decoder = Decoder(wire)
        frames = len(decoder.feed(data)) + len(decoder.finish())
        if frames:
            found.append(Likeness(name, frames, 1 - decoder.counters.skipped_bytes / len(data)))
    return sorted(found, key=lambda likeness: -likeness.share_of_bytes)
