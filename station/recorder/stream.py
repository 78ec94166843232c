"""Chunks of bytes to samples in sequence: counters unwrapped, repeats dropped, every break seen.

A break is where increments are missing or time does not go on: a lost frame, a device that began anew, a port
that was closed in between. What stands on its two sides is never averaged over it.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from drivers.continuity import unwrap
from drivers.framing import Decoder
from drivers.wire import WireFormat
from procedures.arrays import IntArray
from procedures.records import CountBlock
from station.reader import Chunk

GAP = 1.5  # sample periods, as in campaign folders
LEARNING = 33  # samples from which the period is taken where the device does not state it


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A chunk and the samples that it completed.

    ``block`` holds the samples, counters unwrapped; ``edges`` (n, 2) says where the bytes of each begin and end,
    counted from the chunk's first; ``breaks`` the samples before which something is missing. ``anew`` is the
    sample from which device or port have begun anew, so that nothing before it has a relation in time to it; None
    if they have not.
    """

    chunk: Chunk
    block: CountBlock
    edges: IntArray
    breaks: IntArray
    anew: int | None


@dataclass(slots=True)
class StreamCounters:
    """What was met beside good samples; ``lost`` are frames by their counter, where the format has one."""

    samples: int = 0
    repeated: int = 0
    breaks: int = 0
    lost: int = 0
    restarts: int = 0


class SampleStream:
    """Decodes one device's chunks in order."""

    def __init__(self, wire: WireFormat) -> None:
        self.decoder = Decoder(wire)
        self.counters = StreamCounters()
        self._modulus = wire.counter_modulus
        self._counter: int | None = None
        self._time = np.nan
        self._learnt: list[float] = []
        self._is_anew = True

    @property
    def period(self) -> float | None:
        """The sample period [s]: as the device states it, else the median of the first ones; None before that.

        A format without a frame counter states no more than its model's usual rate: there the times decide.
        """
        stated = self.decoder.identity.period if self.decoder.identity and self._modulus else 0.0
        if stated > 0:
            return stated
        return float(np.median(self._learnt)) if len(self._learnt) >= LEARNING else None

    def begin_anew(self) -> None:
        """Take the next sample as a new beginning, as after a gap mark."""
        self._is_anew = True

    def take(self, chunk: Chunk) -> Piece:
        """Decode a chunk."""
        block = self.decoder.feed(chunk.data)
        n = len(block)
        if not n:
            return Piece(chunk, block, self.decoder.edges, np.arange(0), None)
        if self._is_anew:
            self._counter, self._time = None, np.nan
        steps, seconds = self._steps(block), np.diff(block.device_time, prepend=self._time)
        self._time = float(block.device_time[-1])
        self._learn(seconds)
        counter = self._counter if self._counter is not None else int(block.counter[0]) - 1
        block = replace(block, counter=counter + np.cumsum(steps))
        self._counter = int(block.counter[-1])
        repeat = steps == 0 if self._modulus else seconds == 0
        back = ~repeat & ((steps < 0) | (seconds <= 0))
        period = self.period
        missing = (steps > 1) | (seconds > GAP * period if period else np.zeros(n, dtype=bool))
        self._count(repeat, back, missing, steps)
        back[0] |= self._is_anew
        self._is_anew = False
        kept = np.flatnonzero(~repeat)
        rows = {f.name: getattr(block, f.name)[kept] for f in fields(CountBlock)}
        breaks, begins = np.flatnonzero((back | missing)[kept]), np.flatnonzero(back[kept])
        anew = int(begins[-1]) if len(begins) else None
        return Piece(chunk, CountBlock(**rows), self.decoder.edges[kept], breaks, anew)

    def _steps(self, block: CountBlock) -> IntArray:
        """Return by how many samples the sequence goes on at each frame; all ones where nothing counts them."""
        if self._modulus is None:
            return np.ones(len(block), dtype=np.int64)
        first = int(block.counter[0]) - 1
        last = first if self._counter is None else self._counter
        return np.diff(unwrap(block.counter, self._modulus, last), prepend=last)

    def _learn(self, seconds: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
        if len(self._learnt) < LEARNING:
            self._learnt += seconds[np.isfinite(seconds) & (seconds > 0)].tolist()

    def _count(self, *what: np.ndarray[tuple[int], np.dtype[np.bool_]] | IntArray) -> None:
        repeat, back, missing, steps = what
        self.counters.samples += len(repeat) - int(repeat.sum())
        self.counters.repeated += int(repeat.sum())
        self.counters.breaks += int(missing.sum())
        self.counters.lost += int((steps[steps > 1] - 1).sum())
        self.counters.restarts += int(back.sum())
