"""A byte stream to checked frames: survives any cut, noise and false sync; no I/O, bounded memory.

From a sync on, the bytes are a frame if kind, length and check agree; if not, the search goes on one byte after
that sync. What is decided depends on the bytes alone, never on how the stream was cut.
"""

import re
from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from drivers.counter_and_time_wrap import StepGate, continuity_watch
from drivers.wire import FORMATS, FrameCounters, FrameKind, Identity, Lines, WireFormat
from procedures.arrays import IntArray
from procedures.counts.sample_records import SampleBlock, joined_blocks

STRONG_CHECK_BITS = 16  # a check of fewer also passes in other formats' bytes
MIN_BATCH_BYTES = 2048  # bytes of text that are worth looking at as lines together


class FrameRun(NamedTuple):
    """Frames of one kind that stand end to end in a buffer; ``lines`` are those of text."""

    kind: FrameKind
    begin: int
    end: int
    lines: Lines | None = None


class Decoder:
    """Turns a stream of bytes into blocks, as they come.

    ``counters`` says what was met; ``identity``, ``model`` and ``serial`` who the device last reported it is;
    ``kind`` which kind of frame held the last sample. ``edges`` (n, 2) says where the bytes of each sample of
    the last block begin and end, counted from the first byte that was then fed: a begin is negative where they
    began before.
    """

    def __init__(self, wire: WireFormat) -> None:
        self.wire = wire
        self.counters = FrameCounters()
        self.identity: Identity | None = None
        self.kind = wire.imu
        self.edges: IntArray = np.zeros((0, 2), np.int64)
        self._kinds = wire.kinds
        self._fixed = {kind.prefix: kind for kind in (wire.imu, *wire.others) if kind.text is None}
        self._head = len(wire.imu.prefix)
        self._maimed = {_without_length(prefix, wire.length_at) for prefix in self._kinds}
        self._starts = re.compile(b"[" + b"".join(re.escape(prefix[:1]) for prefix in self._kinds) + b"]")
        self._pending = b""
        self._none = wire.decode(np.frombuffer(b"", wire.frame))  # what most feeds of a few bytes complete
        self._joiner = wire.joiner(self.counters) if wire.joiner is not None else None
        self._fed = 0  # bytes of the stream so far
        self._is_after_frame = False  # so that a trailer may come
        self._watch = continuity_watch(wire)
        self._gate = None if wire.max_step is None else StepGate(wire.max_step)

    @property
    def model(self) -> str | None:
        """The model that the device says it is, None while it has not reported."""
        return (self.identity.model or None) if self.identity else None

    @property
    def serial(self) -> str | None:
        """The serial number that the device says it has, None while it has not reported."""
        return (self.identity.serial or None) if self.identity else None

    def feed(self, data: bytes) -> SampleBlock:
        """Return the frames that ``data`` completes, possibly none."""
        return self._take(self._pending + data, len(data), at_end=False)

    def finish(self) -> SampleBlock:
        """Return what the bytes still waiting hold when no more will come; the rest of them is skipped."""
        return self._take(self._pending, 0, at_end=True)

    def _take(self, buffer: bytes, new: int, *, at_end: bool) -> SampleBlock:
        runs, at = self._runs(buffer, at_end=at_end)
        self._pending = buffer[at:]
        self.edges = _edges(runs) - (len(buffer) - new)
        if self._joiner is None:
            block = self._decode(buffer, runs)
        else:
            frames = np.frombuffer(_rows(buffer, runs), self.wire.frame)
            block, edges = self._joiner.take(frames, self.edges[:, 0] + self._fed)
            self.edges = edges - self._fed
        self._fed += new
        if len(block):
            self.counters.frames += len(block)
            if self._gate is not None:
                self._gate.shut(block)
            self.counters.bad_status += int(np.count_nonzero(~block.healthy))
            self.counters.counter_jumps += self._watch.jumps(block) if self._watch else 0
        return block

    def _runs(self, buffer: bytes, *, at_end: bool) -> tuple[list[FrameRun], int]:
        """Return the IMU frames in ``buffer`` and how far it is decided."""
        head, total, trailer = self._head, len(buffer), self.wire.trailer
        view, runs, together = memoryview(buffer), list[FrameRun](), self._together(buffer)
        at = kept = 0  # where the search stands; bytes in accepted frames
        while True:
            if self._is_after_frame:
                follows = buffer[at : at + len(trailer)]
                if follows != trailer and trailer.startswith(follows) and not at_end:
                    break
                self._is_after_frame = False
                if follows == trailer:
                    at, kept = at + len(trailer), kept + len(trailer)
            found = self._starts.search(buffer, at)
            if (at := total if found is None else found.start()) + head > total:
                break
            kind = self._fixed.get(buffer[at : at + head])
            end = at if kind is None else self._end_of_run(kind, buffer, view, at)
            if kind is not None and end > at:
                runs.append(FrameRun(kind, at, end))
            elif at in together:
                runs.append(together[at])
                end = runs[-1].end
            else:
                end = self._other(buffer, at, runs)
                if end > total and not at_end:
                    break
            if at < end <= total:
                kept += end - at
                at = end
                self._is_after_frame = bool(trailer)
            else:
                at += 1
        if at_end:
            at = total
        self.counters.skipped_bytes += at - kept
        return runs, at

    def _together(self, buffer: bytes) -> dict[int, FrameRun]:
        """Return lines of text that can be read together, by where the first begins."""
        kind = self.wire.imu
        if kind.text is None or kind.text.lines is None or len(buffer) < MIN_BATCH_BYTES:
            return {}
        found = [(int(each.edges[0, 0]), int(each.edges[-1, 1]), each) for each in kind.text.lines(buffer)]
        return {begin: FrameRun(kind, begin, end, each) for begin, end, each in found}

    def _end_of_run(self, kind: FrameKind, buffer: bytes, view: memoryview, at: int) -> int:
        """Return where the intact frames of ``kind`` that stand end to end from ``at`` on stop."""
        prefix, size, is_intact = kind.prefix, kind.size, self.wire.is_intact
        last = len(buffer) - size
        while at <= last and buffer.startswith(prefix, at) and is_intact(view[at : at + size]):
            at += size
        return at

    def _other(self, buffer: bytes, at: int, runs: list[FrameRun]) -> int:
        """Return the end of what begins at ``at`` and is no frame of fixed size; ``at`` if nothing does."""
        head = buffer[at : at + self._head]
        kind = self._kinds.get(head)
        if kind is None:
            self.counters.bad_length += _without_length(head, self.wire.length_at) in self._maimed
            return at
        end = at + kind.size if kind.text is None else kind.text.end(buffer, at)
        if end > len(buffer):
            return end
        frame = buffer[at:end]
        if head in self._fixed or end == at or not self.wire.is_intact(frame):
            self.counters.bad_crc += 1
            return at
        if kind.text is None:
            if kind is self.wire.identity:
                self.counters.identities += 1
                self._identify(frame)
            return end
        try:
            runs.append(FrameRun(kind, at, end, Lines(kind.text.row(frame), np.array([[at, end]]))))
        except ValueError:
            self.counters.bad_length += 1
            return at
        return end

    def _identify(self, frame: bytes) -> None:
        if self.wire.identify is not None:
            self.identity = self.wire.identify(frame)

    def _decode(self, buffer: bytes, runs: Sequence[FrameRun]) -> SampleBlock:
        blocks = list[SampleBlock]()
        for kind_id, same in groupby(runs, key=lambda run: id(run.kind)):
            together = list(same)
            self.kind = together[-1].kind
            rows = _rows(buffer, together)
            if self.wire.identity is not None and id(self.wire.identity) == kind_id:
                self._identify(rows[-self.kind.dtype.itemsize :])
            blocks.append(self.wire.decode(np.frombuffer(rows, self.kind.dtype)))
        return joined_blocks(blocks) if blocks else self._none


def _rows(buffer: bytes, runs: Sequence[FrameRun]) -> bytes:
    return b"".join(buffer[run.begin : run.end] if run.lines is None else run.lines.rows for run in runs)


def _edges(runs: Sequence[FrameRun]) -> IntArray:
    """Return where each frame begins and ends in the buffer."""
    if not runs:
        return np.zeros((0, 2), np.int64)
    lines = [run.lines.edges for run in runs if run.lines is not None]
    if lines:  # a format's frames are all lines of text, or none is
        return np.concatenate(lines)
    table = [(run.begin, run.end, run.kind.size) for run in runs]
    begin, end, size = np.array(table, dtype=np.int64).reshape(-1, 3).T
    count = (end - begin) // size
    nth = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    at = np.repeat(begin, count) + nth * np.repeat(size, count)
    return np.stack((at, at + np.repeat(size, count)), axis=1)


def _without_length(prefix: bytes, length_at: int | None) -> bytes:
    return prefix if length_at is None else prefix[:length_at] + prefix[length_at + 1 :]


def seen_instead(wire: WireFormat, data: bytes) -> str:
    """Return what came where samples of several frames never become whole; empty where that is not known."""
    decoder = Decoder(wire)
    decoder.feed(data)
    counters = decoder.counters
    one_device = "check that one device alone sends and that its frames are those of dbc and map"
    for count, seen in (
        (counters.incomplete, f"samples miss frames; {one_device}"),
        (counters.foreign, "frames have other identifiers; check dbc and map"),
        (counters.bus_errors, "bus errors or garbled lines; check bit rate, tty_baudrate and termination"),
    ):
        if count > counters.frames:
            return f"{count} {seen}"
    return ""


class FormatMatch(NamedTuple):
    """How much of some bytes is frames of a format."""

    format: str
    frames: int
    share_of_bytes: float


def sniff(data: bytes) -> list[FormatMatch]:
    """Return every format of which ``data`` holds frames, the one that explains most bytes first.

    A format with a weak check is named where it explains more than half of them: a few bytes pass it by chance.
    """
    found = []
    for name, wire in FORMATS.items():
        decoder = Decoder(wire)
        frames = len(decoder.feed(data)) + len(decoder.finish())
        share = 1 - decoder.counters.skipped_bytes / max(1, len(data))
        if frames and (wire.check_bits >= STRONG_CHECK_BITS or share > 0.5):
            found.append(FormatMatch(name, frames, share))
    return sorted(found, key=lambda match: -match.share_of_bytes)
