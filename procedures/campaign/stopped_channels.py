"""Did a channel stop within a step? One that ends constant has, if it cannot have gone on so as it was before.

At rest it would have changed `MIN_EXPECTED_CHANGES` times, as often as it did before, and moved by more than
`MIN_MISSED_COUNTS` counts or walked by chance beyond one. A turn ends at the heading where it began: what was
before is the rest at its start, and a gyroscope along its axis neither stops nor holds its rate from one sample to
the next. Of a sequence, what was before is what moved least, and other channels went on to move.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import SequenceRecord, TurnRecord
from procedures.counts.sample_records import CountSeries

MIN_MISSED_COUNTS = 10.0  # counts, beyond six sigmas of what the other rests scatter
MIN_EXPECTED_CHANGES = 30.0  # changes, where none came
# counts^2: a walk stays within one count by exp(-pi^2/2 of it); twice, as eight blocks know it
MIN_WALK_COUNTS2 = 16.0
WALK_BLOCKS = 8
MIN_NOISE_LEVELS = 5  # different values of a rate output from which on its noise is several steps of the converter
MIN_CONSTANT_SAMPLES = 8  # samples, below which an end without a change says nothing
MAX_BRAKED_SHARE = 0.2  # of the highest rate of a turn: more than a hand takes away between two samples
MIN_TURN_LEVELS = 20  # different values in a turn, of an output that shows how it is braked
MOVING_RATE_SHARE = 0.02  # of the highest rate of a turn: less is rest
SEQUENCE_WINDOWS = 5  # of what came before in a sequence
MOVING_SPAN_SHARE = 0.5  # of what another channel moves in all of a sequence, to say that it goes on to move


@dataclass(frozen=True, slots=True)
class ConstantEnd:
    """One value from a sample on to the end of a step: ``begin`` 0 is all of it."""

    begin: int
    value: float


def constant_end(values: FloatArray) -> ConstantEnd | None:
    """Return the stretch without a change at the end; None if it is shorter than `MIN_CONSTANT_SAMPLES`.

    ``values`` (n,) are a channel's samples [count, or the unit of a rate output].
    """
    changes = np.flatnonzero(np.diff(values) != 0)
    begin = int(changes[-1]) + 1 if len(changes) else 0
    return ConstantEnd(begin, float(values[-1])) if len(values) - begin >= MIN_CONSTANT_SAMPLES else None


def stopped(values: FloatArray, found: ConstantEnd, counts: bool) -> bool:
    """Say whether a channel at rest, ``values`` (n,), stopped: what it did before cannot have gone on so."""
    before = values[: found.begin]
    tail = len(values) - found.begin
    if found.begin < MIN_CONSTANT_SAMPLES:
        return False
    often = np.count_nonzero(np.diff(before)) / (len(before) - 1)
    if often * tail < MIN_EXPECTED_CHANGES:
        return False
    if counts:
        drift = abs(before.mean() - found.value) * tail > MIN_MISSED_COUNTS + 6 * np.sqrt(before.var() * tail)
        return bool(drift or walk(before) * tail > MIN_WALK_COUNTS2)
    is_outside = found.value < before.min() or found.value > before.max()
    return is_outside or len(np.unique(before)) >= MIN_NOISE_LEVELS


def walk(before: FloatArray) -> float:
    """Return by how many counts^2 a sample the sum of ``before`` (n,) walks, flicker at an edge left out."""
    length = max(len(before) // WALK_BLOCKS, 1)  # the same of all: sums of other lengths differ by their mean
    sums = before[: len(before) // length * length].reshape(-1, length).sum(axis=1)
    return max(float(sums.var(ddof=1)) - 1.0, 0.0) / length


def stopped_in_turn(turn: TurnRecord, values: FloatArray, end: ConstantEnd, is_along: bool) -> bool:
    """Say whether a channel, ``values`` (n,), stopped in a turn; if its rest is constant too, by the way."""
    samples = np.asarray(turn.series.gyro if turn.series.gyro is not None else turn.series.accel)
    off = np.abs(samples - samples[:MIN_CONSTANT_SAMPLES].mean(axis=0))
    moving = np.flatnonzero(np.any(off > MOVING_RATE_SHARE * off.max(initial=0.0), axis=1))
    still = min(int(moving[0]) if len(moving) else len(values), end.begin)
    rest = values[: still // 2]  # a hand begins slowly
    both = np.concatenate((rest, values[end.begin :]))
    if stopped(both, ConstantEnd(len(rest), end.value), isinstance(turn.series, CountSeries)):
        return True
    if not is_along or len(np.unique(values)) < MIN_TURN_LEVELS:
        return False
    begin = float(np.mean(values[:MIN_CONSTANT_SAMPLES]))
    jump = max(abs(values[end.begin - 1] - end.value), abs(end.value - begin))
    return bool(jump > MAX_BRAKED_SHARE * np.max(np.abs(values - begin)))


def stopped_in_sequence(record: SequenceRecord, values: FloatArray, end: ConstantEnd) -> bool:
    """Say whether a channel, ``values`` (n,), stopped while the others of the unit went on to move."""
    parts = [
        part for part in np.array_split(values[: end.begin], SEQUENCE_WINDOWS) if len(part) > MIN_CONSTANT_SAMPLES
    ]
    if len(parts) < SEQUENCE_WINDOWS:
        return False
    often = min(np.count_nonzero(np.diff(part)) / (len(part) - 1) for part in parts)
    triads = [v for v in (record.series.gyro, record.series.accel) if v is not None]
    others = [np.asarray(v, dtype=np.float64) for v in triads]
    spans = [(np.ptp(each[end.begin :], axis=0), np.ptp(each, axis=0)) for each in others]
    moved = any(np.count_nonzero((whole > 0) & (late > MOVING_SPAN_SHARE * whole)) for late, whole in spans)
    return bool(moved and often * (len(values) - end.begin) >= MIN_EXPECTED_CHANGES)
