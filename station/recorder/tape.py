"""The stream's last stretch in memory: samples by number, with the bytes they came in."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import fields

import numpy as np

from drivers.wire import WireFormat
from procedures.records import CountBlock
from station.reader import Chunk
from station.recorder.raw_cut import cut, longest_frame
from station.recorder.stream import Piece

Run = tuple[int, int]  # first sample, one beyond the last: consecutive, no break in between


class Tape:
    """Samples are numbered from 0 at the session's first; old ones are let go by `forget_before`."""

    def __init__(self, wire: WireFormat) -> None:
        self.wire = wire
        self.end = 0
        self.breaks: list[int] = []
        self._pieces: list[Piece] = []
        self._firsts: list[int] = []
        self._before = b""  # bytes just before the first piece: a frame may begin there

    def append(self, piece: Piece) -> None:
        """Take a piece; one that begins anew cuts off all that was there."""
        if piece.is_anew:
            self.forget_before(self.end)
        self.breaks += (piece.breaks + self.end).tolist()
        if piece.is_anew:
            self.breaks.append(self.end)
        self._pieces.append(piece)
        self._firsts.append(self.end)
        self.end += len(piece.block)

    def forget_before(self, sample: int) -> None:
        """Let go the pieces whose samples all stand before ``sample``."""
        count = 0
        while count < len(self._pieces) and self._firsts[count] + len(self._pieces[count].block) <= sample:
            count += 1
        if count:
            # a piece without a sample of its own may hold the beginning of the next one's first frame
            tail = self._before + b"".join(piece.chunk.data for piece in self._pieces[max(0, count - 64) : count])
            self._before = tail[1 - longest_frame(self.wire) :]
            del self._pieces[:count], self._firsts[:count]
            self.breaks = [b for b in self.breaks if b >= sample]

    def block(self, first: int, last: int) -> CountBlock:
        """Return the samples from ``first`` up to before ``last``."""
        parts = [piece_block for _, piece_block, _ in self._parts(first, last)]
        names = [f.name for f in fields(CountBlock)]
        return CountBlock(**{name: np.concatenate([getattr(p, name) for p in parts]) for name in names})

    def recording(self, runs: Sequence[Run]) -> Iterator[tuple[Chunk, CountBlock]]:
        """Yield the bytes of the runs' samples, cut at frames, and the samples that each piece completed."""
        for first, last in runs:
            for index, block, (low, high) in self._parts(first, last):
                piece, at = self._pieces[index], self._firsts[index]
                is_first, is_last = at + low == first, at + high == last
                data = piece.chunk.data
                if is_first or is_last:
                    begin = int(piece.frame[low]) if is_first else 0
                    end = int(piece.frame[high - 1]) if is_last else None
                    data = self._cut(index, begin, end, keep_head=not is_first)
                yield Chunk(piece.chunk.host_ns, data), block

    def _cut(self, index: int, begin: int, end: int | None, *, keep_head: bool) -> bytes:
        before, data = self._preceding(index), self._pieces[index].chunk.data
        piece = cut(self.wire, before, data, begin, end)
        if keep_head:  # everything of this chunk up to the end: what came before stands in the one before
            whole = len(before) + len(data)
            return data[: len(data) - (whole - (before + data).find(piece) - len(piece))]
        return piece

    def _preceding(self, index: int) -> bytes:
        wanted, tail = longest_frame(self.wire) - 1, b""
        while len(tail) < wanted and index > 0:
            index -= 1
            tail = self._pieces[index].chunk.data + tail
        return (self._before + tail if len(tail) < wanted else tail)[-wanted:]

    def _parts(self, first: int, last: int) -> Iterator[tuple[int, CountBlock, tuple[int, int]]]:
        index = max(0, bisect_right(self._firsts, first) - 1)
        while index < len(self._pieces) and self._firsts[index] < last:
            at, block = self._firsts[index], self._pieces[index].block
            low, high = max(first - at, 0), min(last - at, len(block))
            if high > low:
                rows = {f.name: getattr(block, f.name)[low:high] for f in fields(CountBlock)}
                yield index, CountBlock(**rows), (low, high)
            index += 1
