"""The samples of recordings at rest, channel by channel, in natural units where they are known."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, SequenceRecord, SoakRecord, TurnRecord
from procedures.campaign.observations import channel
from procedures.counts.missing_rows import INTERPOLATED, TRIAD_BITS
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import AXES, TRIADS
from procedures.free_positions.gyroscopes_from_moves import segment

Record = DwellRecord | RestRecord | SoakRecord | SequenceRecord | TurnRecord
LOOKED_AT, COARSE_LEVELS = 20000, 32  # samples; levels in them, up to which an output is coarse
Scales = Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class HeldChannel:
    """A channel of a recording: ``rate`` (n,) over ``scale``, ``period`` [s] apart, in gap-free ``parts``.

    ``scale`` is the outputs a second in 1 g or 1 deg/s, 1 where it is not known; ``quantum`` what one count is, in
    the unit of the rate times seconds, 0 of an output that is not counted.
    """

    triad: str
    axis: int
    recording: str
    series: Series
    rate: FloatArray
    period: float
    scale: float
    quantum: float

    @property
    def name(self) -> str:
        """Triad and axis."""
        return f"{self.triad} {AXES[self.axis]}"

    @property
    def step(self) -> float:
        """By how much two outputs differ at the least, in the unit of the rate; 0 where they are not coarse."""
        if self.quantum:
            return self.quantum / self.period
        levels = np.unique(self.rate[:LOOKED_AT])
        return float(np.diff(levels).min()) if 1 < len(levels) <= COARSE_LEVELS else 0.0

    @property
    def is_measured(self) -> BoolArray:
        """Say of each row (n,) whether its value was measured, not interpolated between others."""
        bits = self.series.extra.get(INTERPOLATED, np.zeros(len(self.rate))).astype(np.int64)
        measured: BoolArray = (bits & TRIAD_BITS[self.triad]) == 0
        return measured

    @property
    def parts(self) -> list[slice]:
        """The gap-free parts."""
        edges = [*self.series.starts.tolist(), len(self.rate)]
        return [slice(i, j) for i, j in pairwise(edges) if j > i]

    @property
    def longest(self) -> slice:
        """The longest gap-free part."""
        return max(self.parts, key=lambda part: part.stop - part.start)


def known_scales(campaigns: Sequence[Campaign], solution: Solution | None) -> Scales:
    """Return the outputs a second in 1 g or 1 deg/s (3,) of triads that are solved, or whose unit was stated."""
    found = dict[str, FloatArray]()
    for triad in TRIADS:
        calibrated = None if solution is None else getattr(solution, triad)
        if calibrated is not None:
            found[triad] = np.asarray(calibrated.scale_factor.value, dtype=np.float64)
        elif (stated := campaigns[0].nominal_scale.get(triad)) is not None:
            found[triad] = np.full(3, float(stated))
    return found


def records_at_rest(campaigns: Sequence[Campaign]) -> list[Record]:
    """Return soaks, dwells and rests, those found within sequences too; whole sequences where nothing rests."""
    held = list[Record]()
    for one in campaigns:
        held += [*one.soaks, *one.dwells, *one.rests]
    if any(campaign.sequences for campaign in campaigns):
        held += [rest for sequence in segment(campaigns) for rest in sequence.rests]
    return held or [each for one in campaigns for each in one.sequences]


def held_channels(record: Record, scales: Scales) -> Iterator[HeldChannel]:
    """Yield a recording's channels, but for those that never change."""
    for triad in TRIADS:
        samples = channel(record.series, triad)
        if samples is None:
            continue
        for axis in range(3):
            scale = float(scales[triad][axis]) if triad in scales else 1.0
            if np.ptp(samples[:, axis]) > 0:
                yield held_channel(record.series, record.name, triad, axis, scale)


@lru_cache(maxsize=len(TRIADS) * len(AXES))  # noise is asked for of the same channels by two
def held_channel(series: Series, name: str, triad: str, axis: int, scale: float) -> HeldChannel:
    """Return a channel of a triad that the series has, its outputs over ``scale`` [output/s by g or deg/s]."""
    samples, is_count = channel(series, triad), isinstance(series, CountSeries)
    assert samples is not None
    rate = np.asarray(samples[:, axis], dtype=np.float64) / (scale * (series.period if is_count else 1.0))
    return HeldChannel(triad, axis, name, series, rate, series.period, scale, 1 / abs(scale) if is_count else 0.0)


def constant_channels(records: Sequence[Record]) -> list[str]:
    """Return the channels that never change in any of the recordings; always 0 is one that is not there."""
    alive, there = set[str](), set[str]()
    for record in records:
        for triad in TRIADS:
            if (samples := channel(record.series, triad)) is not None:
                names = [f"{triad} {axis}" for axis in AXES]
                there |= {name for i, name in enumerate(names) if samples[:, i].any()}
                alive |= {name for i, name in enumerate(names) if np.ptp(samples[:, i]) > 0}
    return sorted(there - alive)
