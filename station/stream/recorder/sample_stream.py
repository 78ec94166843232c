"""Chunks of bytes to samples in sequence: counters unwrapped, repeats dropped, every break seen.

`raw_check` decodes a step's recorded bytes again and compares them with its samples.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.counter_and_time_wrap import unwrap, unwrap_steps
from drivers.framing import Decoder
from drivers.host_times import HostTimes
from drivers.wire import WireFormat
from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import SampleBlock, block_rows
from procedures.counts.sample_times import GAP_PERIODS
from station.errors import Altered
from station.files.mcap_files import read_step
from station.stream.reader import Chunk

PERIOD_SAMPLES = 33  # samples from which the period is taken where the device does not state it


@dataclass(frozen=True, slots=True, eq=False)
class DecodedChunk:
    """A chunk and the samples that it completed.

    ``block`` holds the samples, counters and device time unwrapped; ``edges`` (n, 2) says where the bytes of
    each begin and end, counted from the chunk's first; ``breaks`` the samples before which something is missing.
    ``restart_at`` is the first sample after a restart of device or port, so that nothing before it has a relation
    in time to it; None if they have not.
    """

    chunk: Chunk
    block: SampleBlock
    edges: IntArray
    breaks: IntArray
    restart_at: int | None


@dataclass(slots=True)
class StreamCounters:
    """What was met alongside good samples; ``lost`` are frames by their counter, where the format has one.

    ``contradicted`` are those of the repeated ones that say something else, as another device's would, and frames
    that do where a sample takes several;
    ``clock_jumps`` breaks in the device's time where its counter continues.
    """

    samples: int = 0
    repeated: int = 0
    breaks: int = 0
    lost: int = 0
    restarts: int = 0
    contradicted: int = 0
    clock_jumps: int = 0


class SampleStream:
    """Decodes one device's chunks in order."""

    def __init__(self, wire: WireFormat) -> None:
        self.decoder = Decoder(wire)
        self.counters = StreamCounters()
        self._modulus = wire.counter_modulus
        self._counter: int | None = None
        self._time = np.nan
        self._host = HostTimes()
        self._learnt: list[float] = []
        self._is_restarted = True
        self._values: FloatArray | IntArray | None = None  # of the newest frame
        self._is_ambiguous = False  # it was contradicted

    @property
    def period(self) -> float | None:
        """The sample period [s]: as the device states it, else the median of the first ones; None before that.

        A format without a frame counter states no more than its model's usual rate: there the times decide.
        Where the device sends no time, it is the host's that the samples came in.
        """
        if not self.decoder.kind.has_time:
            return self._host.period
        stated = self.decoder.identity.period if self.decoder.identity and self._modulus else 0.0
        if stated > 0:
            return stated
        return float(np.median(self._learnt)) if len(self._learnt) >= PERIOD_SAMPLES else None

    def reset(self) -> None:
        """Take the next sample as a new beginning, as after a gap mark."""
        self._is_restarted = True

    def take(self, chunk: Chunk) -> DecodedChunk:
        """Decode a chunk."""
        before = self.decoder.counters.contradicted
        block = self.decoder.feed(chunk.data)
        contradicted = self.decoder.counters.contradicted - before
        self.counters.contradicted += contradicted
        n = len(block)
        if not n:
            self._is_ambiguous |= contradicted > 0
            return DecodedChunk(chunk, block, self.decoder.edges, np.arange(0), None)
        if self._is_restarted:
            self._counter, self._time, self._values, self._is_ambiguous = None, np.nan, None, False
            self._host.reset()
        steps = self._steps(block)
        time, seconds = self._times(chunk, block, steps)
        self._time = float(time[-1])
        self._learn(seconds)
        counter = self._counter if self._counter is not None else int(block.counter[0]) - 1
        block = replace(block, counter=counter + np.cumsum(steps), device_time=time)
        self._counter = int(block.counter[-1])
        repeat = steps == 0 if self._modulus else seconds == 0
        back = ~repeat & ((steps < 0) | (seconds <= 0))
        period = self.period
        missing = (steps > 1) | (seconds > GAP_PERIODS * period if period else np.zeros(n, dtype=bool))
        self._count(repeat, back, missing, steps)
        missing |= self._ambiguous(block, repeat) | (contradicted > 0)
        self._is_ambiguous |= contradicted > 0
        back[0] |= self._is_restarted
        self._is_restarted = False
        kept = np.flatnonzero(~repeat)
        breaks, begins = np.flatnonzero((back | missing)[kept]), np.flatnonzero(back[kept])
        restart_at = int(begins[-1]) if len(begins) else None
        return DecodedChunk(chunk, block_rows(block, kept), self.decoder.edges[kept], breaks, restart_at)

    def _times(self, chunk: Chunk, block: SampleBlock, steps: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return each sample's time [s] and how far it is from the one before."""
        if not self.decoder.kind.has_time:
            time = self._host.take(chunk.host_ns / 1e9, steps)
            self._is_restarted |= self._host.is_reset
            return time, np.diff(time, prepend=self._time)
        modulus, time = self.decoder.wire.time_modulus, block.device_time
        if modulus is None:
            return time, np.diff(time, prepend=self._time)
        seconds = unwrap_steps(np.diff(time, prepend=self._time), modulus)
        first = time[0] if np.isnan(seconds[0]) else self._time + seconds[0]
        return first + np.concatenate(([0.0], np.cumsum(seconds[1:]))), seconds

    def _steps(self, block: SampleBlock) -> IntArray:
        """Return by how many samples the sequence continues at each frame; all ones where nothing counts them."""
        if self._modulus is None:
            return np.ones(len(block), dtype=np.int64)
        first = int(block.counter[0]) - 1
        last = first if self._counter is None else self._counter
        return np.diff(unwrap(block.counter, self._modulus, last), prepend=last)

    def _ambiguous(self, block: SampleBlock, repeat: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return before which frames something is amiss, as two frames of one number say different things."""
        values = np.hstack((block.gyro, block.accel))
        before = values[:1] if self._values is None else self._values[None]
        differs = repeat & (np.diff(values, axis=0, prepend=before) != 0).any(axis=1)
        self._values = values[-1]
        self.counters.contradicted += int(differs.sum())
        number = np.cumsum(~repeat)  # 0: repeats of what the chunk before ended with
        differing = np.zeros(number[-1] + 1, dtype=bool)
        differing[number[differs]] = True
        differing[0] |= self._is_ambiguous
        self._is_ambiguous = bool(differing[-1])
        differing[1:] |= differing[:-1].copy()
        amiss: NDArray[np.bool_] = ~repeat & differing[number]
        return amiss

    def _learn(self, seconds: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
        if len(self._learnt) < PERIOD_SAMPLES:
            self._learnt += seconds[np.isfinite(seconds) & (seconds > 0)].tolist()

    def _count(self, *what: np.ndarray[tuple[int], np.dtype[np.bool_]] | IntArray) -> None:
        repeat, back, missing, steps = what
        self.counters.samples += len(repeat) - int(repeat.sum())
        self.counters.repeated += int(repeat.sum())
        self.counters.breaks += int(missing.sum())
        self.counters.lost += int((steps[steps > 1] - 1).sum())
        self.counters.restarts += int(back.sum())
        if self._modulus and self.decoder.kind.has_time:
            self.counters.clock_jumps += int(((back | missing) & (steps == 1)).sum())


_WORD = 0xFFFFFFFF
_ROUNDING_NS = 1


def check_raw_bytes(path: Path, wire: WireFormat) -> int:
    """Decode the raw bytes of a step's file again and return how many samples they give, equal to its counts.

    Raise `Altered` if a count, counter, time, temperature or status differs.
    """
    recorded = read_step(path)
    again = SampleStream(wire).take(Chunk(0, b"".join(data for _, data in recorded.raw))).block
    if (recorded.gyro is None and recorded.accel is None) or len(again) != len(recorded):
        raise Altered(path, f"{len(recorded)} samples", f"{len(again)} in the raw bytes next to them")
    triads = {"gyro": (recorded.gyro, again.gyro), "accel": (recorded.accel, again.accel)}
    pairs = {name: pair for name, pair in triads.items() if pair[0] is not None} | {
        "counter": _same_turn(recorded.counter, np.maximum(again.counter, 0) & _WORD, wire.counter_modulus),
        "device time": _times(wire, recorded.device_ns, again),
        "status": (recorded.status, again.status & _WORD),
        "temperature": (np.nan_to_num(recorded.temperature), np.nan_to_num(again.temperature)),
    }
    for name, (found, expected) in pairs.items():
        if len(rows := np.argwhere(found != expected)):
            row = tuple(int(i) for i in rows[0])
            raise Altered(path, f"{name} {found[row]} in sample {row[0]}", f"{expected[row]} in the raw bytes")
    return len(recorded)


def _same_turn(found: IntArray, again: IntArray, modulus: int | None) -> tuple[IntArray, IntArray]:
    """Return two columns without the turns that were counted before the step began."""
    return (found, again) if modulus is None else (found % modulus, again % modulus)


def _times(wire: WireFormat, device_ns: IntArray, again: SampleBlock) -> tuple[IntArray, IntArray]:
    """Return recorded time and time decoded again [ns]; nothing where the host's clock stood in."""
    if "device_time" not in wire.carries:
        return device_ns[:0], device_ns[:0]
    times = np.rint(again.device_time * 1e9).astype(np.int64)
    if wire.joiner is not None and len(times):  # counted from a counter that wraps: from the beginning as recorded
        shifted = times + (device_ns[0] - times[0])
        return device_ns, np.where(np.abs(shifted - device_ns) <= _ROUNDING_NS, device_ns, shifted)
    return _same_turn(device_ns, times, None if wire.time_modulus is None else round(wire.time_modulus * 1e9))
