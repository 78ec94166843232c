"""Is the cube still? Judged second by second from counts, against the least this unit was ever seen to do.

A block is a second of consecutive samples in ten ticks. Its restlessness is the variance of the ticks' counts,
channel by channel. The unit's own noise is the least that the mean over five consecutive blocks ever was; a
block is still where no channel shows more than 16 times that (four times in amplitude: the variance of ten
ticks of white noise passes it once in 10^9).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import (
    BLOCK_FIELDS,
    CountBlock,
    CountSeries,
    SampleBlock,
    Series,
    block_series,
)
from station.stream.recorder.sample_buffer import SampleBuffer, SampleRun

RATE_UNIT = 2.0**27


def as_counts(block: SampleBlock, period: float) -> CountBlock:
    """Return a block of ``period`` [s] as counts; a device that counts has sent them."""
    if isinstance(block, CountBlock):
        return block
    columns = {name: getattr(block, name) for name in BLOCK_FIELDS}
    return CountBlock(**(columns | {name: _counts(columns[name], period) for name in ("gyro", "accel")}))


def series_as_counts(series: Series) -> CountSeries:
    """Return a step's series as counts."""
    if isinstance(series, CountSeries):
        return series
    gyro, accel = (
        None if values is None else _counts(values, series.period) for values in (series.gyro, series.accel)
    )
    return CountSeries(series.t, gyro, accel, series.temperature, series.period, series.starts, series.extra)


def _counts(values: FloatArray, period: float) -> IntArray:
    return np.rint(values * (period * RATE_UNIT)).astype(np.int64)


TICKS_PER_BLOCK = 10
STILL_NOISE_RATIO = 16.0
NOISE_BLOCKS = 5
# count^2: a counter at constant rate varies by up to 0.25 count^2 without any noise
MIN_VARIANCE = 1 / STILL_NOISE_RATIO


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A second of the stream: samples ``first`` up to before ``last``.

    ``rate`` (6,) counts/s, gyros then accelerometers; ``variance`` (6,) of the ticks [count^2]; ``begins`` and
    ``ends`` the device's time [s]; ``temperature`` [degC] the mean, nan where unknown; ``is_healthy`` what the
    device's status says. ``is_broken``: something is missing just before it; ``is_restarted``: device or port have
    restarted since the block before.
    """

    first: int
    last: int
    rate: FloatArray
    variance: FloatArray
    begins: float
    ends: float
    temperature: float
    is_healthy: bool
    is_broken: bool
    is_restarted: bool


def block_of(samples: SampleBlock, first: int, period: float, *, is_broken: bool, is_restarted: bool) -> Block:
    """Return what a block of consecutive samples says; ``period`` [s]."""
    block = as_counts(samples, period)
    counts = np.hstack((block.gyro, block.accel)).astype(float)
    n = len(counts)
    per_tick = n // TICKS_PER_BLOCK
    ticks = counts[: per_tick * TICKS_PER_BLOCK].reshape(TICKS_PER_BLOCK, per_tick, 6).sum(axis=1)
    return Block(
        first=first,
        last=first + n,
        rate=counts.sum(axis=0) / (n * period),
        variance=ticks.var(axis=0, ddof=1),
        begins=float(samples.device_time[0]) - period,
        ends=float(samples.device_time[-1]),
        temperature=_mean_known(samples.temperature),
        is_healthy=bool(samples.healthy.all()),
        is_broken=is_broken,
        is_restarted=is_restarted,
    )


def _mean_known(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


class Stillness:
    """Learns a unit's noise and judges blocks by it."""

    def __init__(self) -> None:
        self.noise: FloatArray = np.full(6, np.inf)
        self._recent: list[FloatArray] = []

    def learn(self, block: Block) -> None:
        """Take a block, still or not."""
        if block.is_restarted:
            self._recent.clear()
        self._recent = [*self._recent, block.variance][-NOISE_BLOCKS:]
        if len(self._recent) == NOISE_BLOCKS:
            self.noise = np.minimum(self.noise, np.mean(self._recent, axis=0))

    @property
    def is_known(self) -> bool:
        """Whether enough was seen to judge."""
        return bool(np.isfinite(self.noise).all())

    @property
    def limit(self) -> FloatArray:
        """The variance (6,) [count^2] up to which a block is still."""
        limit: FloatArray = STILL_NOISE_RATIO * np.maximum(self.noise, MIN_VARIANCE)
        return limit

    def is_still(self, block: Block) -> bool:
        """Judge a block."""
        return self.is_known and block.is_healthy and bool(np.all(block.variance <= self.limit))


def runs_of_blocks(blocks: Sequence[Block], samples: int | None) -> list[SampleRun]:
    """Return the runs of consecutive samples that blocks make up, the first ``samples`` of them."""
    runs, left = list[SampleRun](), samples
    for block in blocks:
        last = block.last if left is None else min(block.last, block.first + left)
        if left is not None:
            left -= last - block.first
        if runs and runs[-1][1] == block.first and not block.is_broken:
            runs[-1] = (runs[-1][0], last)
        elif last > block.first:
            runs.append((block.first, last))
    return runs


def series_of_runs(buffer: SampleBuffer, runs: Sequence[SampleRun], period: float) -> CountSeries:
    """Return the samples of runs as a step's counts; ``period`` [s] where they are too few to determine it."""
    return block_series([as_counts(buffer.block(first, last), period) for first, last in runs], period)
