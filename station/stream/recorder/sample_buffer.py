"""The stream's last stretch in memory: samples by number, with the bytes they came in."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import IntArray
from procedures.counts.sample_records import CountBlock, SampleBlock, block_rows, joined_blocks
from station.stream.reader import Chunk
from station.stream.recorder.sample_stream import DecodedChunk

SampleRun = tuple[int, int]  # first sample, one beyond the last: consecutive, no break in between
_REACH = 2**16  # bytes: how far before a chunk a sample that it completes may begin


class SampleBuffer:
    """Samples are numbered from 0 at the session's first.

    ``begin`` is the first sample of the time that still continues: what came before has no relation to it.
    ``end`` is one beyond the newest, ``first`` the oldest kept. Old samples are let go by `forget_before`.
    """

    def __init__(self) -> None:
        self.begin = self.end = 0
        self.first = 0  # the oldest sample kept
        self._blocks: list[SampleBlock] = []
        self._recorded = (-1, 0)  # the sample, and the byte, up to before which was recorded last
        self._edges: list[IntArray] = []  # of each sample, where its bytes begin and end in the stream
        self._breaks: list[int] = []
        self._bytes = bytearray()
        self._offset = 0  # of the first of these bytes in the stream
        self._stamps: list[int] = []  # by chunk: when it was read [ns] ...
        self._byte_ends: list[int] = []  # ... where its bytes end in the stream
        self._sample_ends: list[int] = []  # ... and one beyond the last sample that it completed

    def append(self, piece: DecodedChunk) -> None:
        """Take a piece."""
        if piece.restart_at is not None:
            self.begin = self.end + piece.restart_at
        self._breaks += (piece.breaks + self.end).tolist()
        if len(piece.block):
            self._blocks.append(piece.block)
            self._edges.append(piece.edges + self._offset + len(self._bytes))
        self._bytes += piece.chunk.data
        self.end += len(piece.block)
        self._stamps.append(piece.chunk.host_ns)
        self._byte_ends.append(self._offset + len(self._bytes))
        self._sample_ends.append(self.end)
        if piece.restart_at is not None:
            self.forget_before(self.begin)

    def reset(self) -> None:
        """Let everything go: what comes next has no relation to it."""
        self.begin = self.end
        self.forget_before(self.end)

    def forget_before(self, sample: int) -> None:
        """Let go the samples before ``sample``."""
        rows, edges = self._compact()
        drop = min(sample, self.end) - self.first
        if drop <= 0:
            return
        self.first += drop
        self._blocks = [block_rows(rows, slice(drop, None))]
        self._edges = [edges[drop:]]
        self._breaks = [b for b in self._breaks if b >= self.first]
        self._forget_chunks(bisect_right(self._sample_ends, self.first))

    def last_break(self, first: int, last: int) -> int | None:
        """Return the last sample after ``first`` and before ``last`` before which something is missing."""
        return next((b for b in reversed(self._breaks) if first < b < last), None)

    def breaks(self, first: int, last: int) -> IntArray:
        """Return the samples (k,) from ``first`` up to before ``last`` before which something is missing."""
        return np.array([b for b in self._breaks if first <= b < last], dtype=np.int64)

    def host_ns(self, sample: int) -> int:
        """Return when the bytes were read that completed a sample [ns]; let it not be one that was let go."""
        return self._stamps[bisect_right(self._sample_ends, sample)]

    def marks(self, first: int, last: int) -> Iterator[tuple[int, int]]:
        """Yield when bytes were read [ns], and the last sample that they completed if it is in the span."""
        for chunk in range(bisect_right(self._sample_ends, first), len(self._sample_ends)):
            sample = self._sample_ends[chunk] - 1
            if sample >= last:
                return
            if chunk == 0 or self._sample_ends[chunk - 1] <= sample:
                yield self._stamps[chunk], sample

    def block(self, first: int, last: int) -> SampleBlock:
        """Return the samples from ``first`` up to before ``last``."""
        return block_rows(self._compact()[0], slice(first - self.first, last - self.first))

    def recording(self, runs: Sequence[SampleRun]) -> Iterator[tuple[Chunk, SampleBlock]]:
        """Yield the bytes of the runs' samples, cut at frames, and the samples that each chunk completed.

        A run that begins where the one recorded last ended brings what stands in between, such as the frame in
        which the unit says who it is.
        """
        for first, last in runs:
            edges = self._compact()[1][first - self.first : last - self.first]
            at, end = int(edges[0, 0]), int(edges[-1, 1])
            if first == self._recorded[0]:
                at = min(at, self._recorded[1])
            at, self._recorded = max(at, self._offset), (last, end)
            chunk = bisect_right(self._sample_ends, first)
            while first < last:
                byte_end, sample_end = min(self._byte_ends[chunk], end), min(self._sample_ends[chunk], last)
                data = bytes(self._bytes[at - self._offset : byte_end - self._offset])
                yield Chunk(self._stamps[chunk], data), self.block(first, sample_end)
                at, first, chunk = byte_end, sample_end, chunk + 1

    def _forget_chunks(self, count: int) -> None:
        """Let go the first chunks, but for the bytes in which the next one's first samples may begin."""
        if not count:
            return
        keep = max(self._byte_ends[count - 1] - _REACH, self._offset)
        del self._bytes[: keep - self._offset]
        del self._stamps[:count], self._byte_ends[:count], self._sample_ends[:count]
        self._offset = keep

    def _compact(self) -> tuple[SampleBlock, IntArray]:
        if len(self._blocks) != 1:
            parts = self._blocks
            if not parts:
                return _EMPTY, np.zeros((0, 2), np.int64)
            self._blocks, self._edges = [joined_blocks(parts)], [np.concatenate(self._edges)]
        return self._blocks[0], self._edges[0]


_NONE = np.zeros(0)
_EMPTY = CountBlock(
    np.arange(0), _NONE, np.zeros((0, 3), np.int64), np.zeros((0, 3), np.int64), _NONE, np.arange(0), _NONE > 0
)
