"""The stream's last stretch in memory: samples by number, with the bytes they came in."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import fields

import numpy as np

from drivers.wire import WireFormat
from procedures.records import CountBlock
from station.reader import Chunk
from station.recorder.raw_cut import frame_edges, longest_frame
from station.recorder.stream import Piece

Run = tuple[int, int]  # first sample, one beyond the last: consecutive, no break in between
_NAMES = tuple(f.name for f in fields(CountBlock))


class Tape:
    """Samples are numbered from 0 at the session's first.

    ``begin`` is the first sample of the time that still goes on: what came before has no relation to it.
    ``end`` is one beyond the newest. Old samples are let go by `forget_before`.
    """

    def __init__(self, wire: WireFormat) -> None:
        self.wire = wire
        self.begin = self.end = 0
        self._breaks: list[int] = []
        self._pieces: list[Piece] = []
        self._firsts: list[int] = []
        self._before = b""  # bytes just before the first piece: a frame may begin there

    def append(self, piece: Piece) -> None:
        """Take a piece."""
        if piece.anew is not None:
            self.begin = self.end + piece.anew
            self.forget_before(self.begin)
        self._breaks += (piece.breaks + self.end).tolist()
        self._pieces.append(piece)
        self._firsts.append(self.end)
        self.end += len(piece.block)

    def forget_before(self, sample: int) -> None:
        """Let go the pieces whose samples all stand before ``sample``."""
        count = 0
        while count < len(self._pieces) and self._firsts[count] + len(self._pieces[count].block) <= sample:
            count += 1
        if count:
            tail = self._before + b"".join(p.chunk.data for p in self._pieces[:count][-longest_frame(self.wire) :])
            self._before = tail[1 - longest_frame(self.wire) :]
            del self._pieces[:count], self._firsts[:count]
            self._breaks = [b for b in self._breaks if b >= sample]

    def last_break(self, first: int, last: int) -> int | None:
        """Return the last sample after ``first`` and before ``last`` before which something is missing."""
        return next((b for b in reversed(self._breaks) if first < b < last), None)

    def block(self, first: int, last: int) -> CountBlock:
        """Return the samples from ``first`` up to before ``last``."""
        parts = [rows for _, rows, _ in self._parts(first, last) if len(rows)]
        return CountBlock(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in _NAMES})

    def recording(self, runs: Sequence[Run]) -> Iterator[tuple[Chunk, CountBlock]]:
        """Yield the bytes of the runs' samples, cut at frames, and the samples that each piece completed."""
        for first, last in runs:
            for index, rows, (low, high) in self._parts(first, last):
                piece, at = self._pieces[index], self._firsts[index]
                begin, end, before = 0, len(piece.chunk.data), b""
                if at + low == first or at + high == last:
                    before = self._preceding(index)
                    edges = frame_edges(self.wire, before, piece.chunk.data)
                    begin = edges[piece.frame[low]][0] if at + low == first else begin
                    end = edges[piece.frame[high - 1]][1] if at + high == last else end
                data = (before + piece.chunk.data)[len(before) + begin : len(before) + end]
                yield Chunk(piece.chunk.host_ns, data), rows

    def _preceding(self, index: int) -> bytes:
        wanted, tail = longest_frame(self.wire) - 1, b""
        while len(tail) < wanted and index > 0:
            index -= 1
            tail = self._pieces[index].chunk.data + tail
        return (self._before + tail)[-wanted:]

    def _parts(self, first: int, last: int) -> Iterator[tuple[int, CountBlock, tuple[int, int]]]:
        """Yield the pieces with samples in a range, and those without any that stand between them."""
        index, at = max(0, bisect_right(self._firsts, first) - 1), first
        while at < last:
            piece, start = self._pieces[index], self._firsts[index]
            low, high = max(first - start, 0), min(last - start, len(piece.block))
            yield index, CountBlock(**{n: getattr(piece.block, n)[low:high] for n in _NAMES}), (low, high)
            at, index = start + high, index + 1
