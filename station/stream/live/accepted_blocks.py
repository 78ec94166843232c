"""From accepted blocks to runs of samples, and from runs to a step's series."""

from collections.abc import Sequence

from procedures.counts.sample_records import CountSeries, block_series
from station.stream.live.rates_as_counts import as_counts
from station.stream.live.stillness import Block
from station.stream.recorder.sample_buffer import SampleBuffer, SampleRun


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
    """Return the samples of runs as a step's counts; ``period`` [s] where they are too few to tell."""
    return block_series([as_counts(buffer.block(first, last), period) for first, last in runs], period)
