"""``disturbance.dwell``: a shock or a vibration inside a step at rest.

Looked for in the local liveliness of every channel (`procedures.anomalies.disturbed_blocks`), since a mean over a
whole dwell hides it; every block of every channel and step has its share of the prior. The disturbed
stretch is cut out: the step becomes segments that share a rate, as after a gap.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from procedures.anomalies.disturbed_blocks import (
    MIN_BLOCK_SAMPLES,
    ChannelSamples,
    JudgedBlocks,
    is_white,
    judge_blocks,
)
from procedures.anomalies.vibration import measure_vibration
from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord
from procedures.campaign.observations import channel
from procedures.counts.sample_records import CountSeries, Series, series_rows
from procedures.frames import TRIADS
from procedures.inference import odds
from procedures.inference.result import EffectTest, Finding
from procedures.positions import face_normal, face_of
from procedures.units import DEG_H_PER_DEG_S

EFFECT = "disturbance.dwell"
MAX_JOINED_GAP_S = 5.0  # stretches nearer than this are one
# Between a stretch and the begin or end of its segment: as short a rest is but two blocks to be judged by
MIN_REST_S = 2.0
LOOKED_AT_S = 150.0  # either side of a stretch that is measured: what is quiet there is its noise
MAX_CUT_SHARE = 0.6  # of a step that is cut: more is no disturbance of it but its state, reported and left in
CHANNEL_LABELS = {"accelerometer": ("ax", "ay", "az"), "gyroscope": ("gx", "gy", "gz")}

Record = TypeVar("Record", DwellRecord, RestRecord)


@dataclass(frozen=True, slots=True, eq=False)
class Disturbance:
    """A stretch of a step to be cut, ``first`` to ``end`` (samples), with its finding; empty if it is left in.

    ``step`` is the number among the campaign's dwells, then its rests; ``log_odds`` are those of the finding.
    """

    campaign: int
    step: int
    first: int
    end: int
    log_odds: float
    finding: Finding


@dataclass(frozen=True, slots=True, eq=False)
class _DisturbedBlock:
    """A block that is livelier than its channel: its step, samples, channel and ln of its odds."""

    step: int
    first: int
    end: int
    triad: str
    axis: int
    log_odds: float


def find_disturbances(
    campaigns: Sequence[Campaign], *, are_soaks: bool = False
) -> tuple[tuple[Disturbance, ...], tuple[EffectTest, ...]]:
    """Find the disturbed stretches of one unit's dwells and rests, and the test made of the liveliest block.

    ``are_soaks``: the rests are soaks, with blocks enough to tell noise's own bursts.
    """
    channels = [_judged(campaign, are_soaks) for campaign in campaigns]
    judged = [blocks for each in channels for *_, blocks in each]
    if not (blocks := sum(len(each.gain) for each in judged)):
        return (), ()
    found = [
        each
        for number, (campaign, here) in enumerate(zip(campaigns, channels, strict=True))
        for each in _disturbances(number, campaign, list(_lively(here, blocks)))
    ]
    most = max(float(each.gain.max(initial=0.0)) for each in judged)
    return tuple(found), (EffectTest(EFFECT, odds.log_odds(most, blocks)),)


def without_disturbances(campaigns: Sequence[Campaign], found: Sequence[Disturbance]) -> tuple[Campaign, ...]:
    """Return the campaigns with the disturbed stretches cut out."""
    return tuple(
        replace(
            campaign, dwells=_cut(campaign.dwells, here, 0), rests=_cut(campaign.rests, here, len(campaign.dwells))
        )
        for number, campaign in enumerate(campaigns)
        for here in ([each for each in found if each.campaign == number],)
    )


def _cut(records: Sequence[Record], found: Sequence[Disturbance], before: int) -> tuple[Record, ...]:
    kept = list[Record]()
    for i, record in enumerate(records):
        keep = np.ones(len(record.series), dtype=bool)
        for each in found:
            if each.step == before + i:
                keep[each.first : each.end] = False
        kept.append(record if keep.all() else replace(record, series=_kept(record.series, keep)))
    return tuple(kept)


def _kept(series: Series, keep: BoolArray) -> Series:
    """Return the samples to keep; what follows samples left out begins a segment."""
    begins = np.zeros(len(series), dtype=bool)
    begins[series.starts] = True
    lost = np.flatnonzero(np.diff(keep.astype(int)) == 1) + 1
    begins[lost] = True
    carried = np.flatnonzero(begins)  # a segment whose first samples are cut begins where the next are kept
    after = np.searchsorted(np.flatnonzero(keep), carried)
    starts = np.unique(after[after < keep.sum()])
    return series_rows(series, keep, starts.astype(np.int64))


def _steps(campaign: Campaign) -> tuple[DwellRecord | RestRecord, ...]:
    return (*campaign.dwells, *campaign.rests)


def _judged(campaign: Campaign, are_soaks: bool = False) -> list[tuple[str, int, list[int], JudgedBlocks]]:
    """Return triad, axis, the steps that hold the channel, and the blocks of one length judged in it."""
    found, steps = list[tuple[str, int, list[int], JudgedBlocks]](), _steps(campaign)
    for triad in TRIADS:
        here = [
            i
            for i, s in enumerate(steps)
            if channel(s.series, triad) is not None and len(s.series) >= MIN_BLOCK_SAMPLES
        ]
        for axis in range(3) if here else ():
            traces = [_trace(steps[i].series, triad, axis) for i in here]
            found += [
                (triad, axis, here, blocks) for blocks in judge_blocks(traces, campaign.counts, is_soak=are_soaks)
            ]
    return found


def _trace(series: Series, triad: str, axis: int) -> ChannelSamples:
    return ChannelSamples(
        np.asarray(channel(series, triad))[:, axis].astype(np.float64), series.starts, series.period
    )


def _lively(
    channels: Sequence[tuple[str, int, list[int], JudgedBlocks]], judged: int
) -> Iterator[_DisturbedBlock]:
    """Return the blocks that are disturbed, likelier than not, of so many that were ``judged``."""
    for triad, axis, steps, blocks in channels:
        for i in np.flatnonzero(blocks.gain > -odds.log_odds(0.0, judged)):
            log_odds = odds.log_odds(float(blocks.gain[i]), judged)
            yield _DisturbedBlock(
                steps[blocks.trace[i]], int(blocks.first[i]), int(blocks.end[i]), triad, axis, log_odds
            )


def _disturbances(number: int, campaign: Campaign, lively: Sequence[_DisturbedBlock]) -> Iterator[Disturbance]:
    steps = _steps(campaign)
    for step in sorted({each.step for each in lively}):
        series = steps[step].series
        here = [each for each in lively if each.step == step]
        for stretch in _stretches(here, round(MAX_JOINED_GAP_S / series.period)):
            inside = [each for each in here if each.first < stretch.stop and each.end > stretch.start]
            yield _measured(number, campaign, step, stretch, inside)


def _stretches(lively: Sequence[_DisturbedBlock], near: int) -> list[slice]:
    """Return the stretches that blocks show, by the shortest of them, longer ones only where none is shorter."""
    found = list[slice]()
    for length in sorted({each.end - each.first for each in lively}):
        blocks = [slice(each.first, each.end) for each in lively if each.end - each.first == length]
        fresh = [b for b in blocks if not any(b.start < s.stop and b.stop > s.start for s in found)]
        found = _joined([*found, *fresh], near)
    return found


def _joined(stretches: Sequence[slice], near: int) -> list[slice]:
    found = list[slice]()
    for each in sorted(stretches, key=lambda s: s.start):
        if found and each.start - found[-1].stop <= near:
            found[-1] = slice(found[-1].start, max(found[-1].stop, each.stop))
        else:
            found.append(each)
    return found


def _measured(
    number: int, campaign: Campaign, step: int, stretch: slice, lively: Sequence[_DisturbedBlock]
) -> Disturbance:
    """Measure a stretch by the triad that shows it, the accelerometers if both do."""
    record = _steps(campaign)[step]
    series, triad = record.series, min(each.triad for each in lively)
    near = round(LOOKED_AT_S / series.period)
    begin, last = max(stretch.start - near, 0), stretch.stop + near
    worst = max((each for each in lively if each.triad == triad), key=lambda each: each.log_odds)
    k = rough_scale(campaign, triad)
    samples = np.asarray(channel(series, triad), dtype=np.float64)[begin:last]
    is_running = campaign.counts and not is_white([_trace(series, triad, axis) for axis in range(3)])
    seen = slice(stretch.start - begin, stretch.stop - begin)
    sine = measure_vibration(samples, k * series.period if campaign.counts else k, series.period, seen, is_running)
    first, end = min(stretch.start, begin + sine.first), max(stretch.stop, begin + sine.end)
    first, end = _to_ends_of_segments(first, end, series)
    if end - first > MAX_CUT_SHARE * len(series):
        first, end = stretch.start, stretch.stop
    t = series.t
    where: dict[str, object] = {"file": record.name, "channel": CHANNEL_LABELS[triad][worst.axis]}
    if isinstance(record, DwellRecord):
        where = {"position": record.position, **where}
    where |= {"from_s": float(t[first] - series.period), "to_s": float(t[end - 1])}
    finding = Finding(
        EFFECT, "procedure", ("x", "y", "z"), sine.amplitude, sine.std,
        "g" if triad == "accelerometer" else "deg/h", where, odds.probability(worst.log_odds),
        "the same position again, with nobody near the surface plate",
        f"{sine.hertz:.3g} Hz" if sine.hertz else "",
    )  # fmt: skip
    is_state = end - first > MAX_CUT_SHARE * len(series)
    return Disturbance(number, step, first, first if is_state else end, worst.log_odds, finding)


def _to_ends_of_segments(first: int, end: int, series: Series) -> tuple[int, int]:
    """Return a stretch (samples) with what little is left before and after it, up to a gap or an end of the step.

    What disturbed it may well have begun, or go on, there: edges that a tremor shifts look like another rate.
    """
    ends, near = np.append(series.starts, len(series)), round(MIN_REST_S / series.period)
    before, after = int(ends[ends <= first].max()), int(ends[ends >= end].min())
    return before if first - before <= near else first, after if after - end <= near else end


def rough_scale(campaign: Campaign, triad: str) -> FloatArray:
    """Return k (3,) roughly [output per g, or per deg/h]: from the dwells' means, or the turns' totals."""
    if triad == "accelerometer":
        rows = [(d.series, face_of(d.position), 1.0) for d in campaign.dwells]
    else:
        rows = [(t.series, face_of(t.start_position), 360.0 * t.revolutions) for t in campaign.turns]
    u, y = list[FloatArray](), list[FloatArray]()
    for series, face, size in rows:
        samples = channel(series, triad)
        if samples is None:
            continue
        per = 1 / series.period if isinstance(series, CountSeries) else 1.0
        u.append(np.abs(campaign.fixture.C_sb @ face_normal(face)))
        total = samples.mean(axis=0) * per
        y.append(total if triad == "accelerometer" else total * len(series) * series.period / size)
    largest = np.max(np.abs(np.array(y) * (np.array(u) > 0.5)), axis=0, initial=0.0) if u else np.zeros(3)
    known = largest[largest > 0]
    stated = known.mean() if len(known) else campaign.nominal_scale.get(triad, 1.0)
    return np.where(largest > 0, largest, stated) / (1.0 if triad == "accelerometer" else DEG_H_PER_DEG_S)
