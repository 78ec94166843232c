"""What a campaign's steps say, reduced to a rate per dwell and a total per turn, each with its sigma."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, TurnRecord
from procedures.counts.count_rate import MIN_DWELL_SAMPLES, RateEstimate, estimate_channels, estimate_dithered
from procedures.counts.dwell_means import count_noise, estimate_rates, output_step, shaken, without_lines
from procedures.counts.sample_records import CountSeries, Series
from procedures.errors import TooShort

Step = TypeVar("Step", DwellRecord, RestRecord)


@dataclass(frozen=True, slots=True, eq=False)
class TriadDwells:
    """One triad's rate (n, 3) [output/s, or output] and its 1 sigma (n, 3) in n dwells, with the estimates."""

    dwells: tuple[tuple[int, DwellRecord], ...]  # (campaign, record)
    rate: FloatArray
    std: FloatArray
    noise: FloatArray  # (3,) white noise, output per sqrt(s)
    estimates: tuple[tuple[RateEstimate, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class TriadRests:
    """One triad's rate (n, 3) [output/s, or output] and its 1 sigma (n, 3) in n rests outside the positions."""

    rests: tuple[tuple[int, RestRecord], ...]  # (campaign, record)
    rate: FloatArray
    std: FloatArray
    noise: FloatArray  # (3,) white noise, output per sqrt(s)


def channel(series: Series, triad: str) -> FloatArray | None:
    """Return the samples (n, 3) of a triad, or None where it is absent."""
    samples = series.accel if triad == "accelerometer" else series.gyro
    return None if samples is None else np.asarray(samples)


def dwell_rates(campaigns: Sequence[Campaign], triad: str, known: TriadDwells | None = None) -> TriadDwells | None:
    """Estimate one triad's rate in every dwell that holds it; None if none does.

    A channel's white noise belongs to the instrument, so all dwells of a campaign share it, but for those that
    something shook. ``known`` is returned where it is of the very same dwells.
    """
    dwells = [(number, dwell) for number, campaign in enumerate(campaigns) for dwell in campaign.dwells]
    found = _holding(dwells, triad)
    if known is not None and found == known.dwells:
        return known
    return TriadDwells(found, *_estimated(found, triad)) if found else None


def rest_rates(rests: Sequence[tuple[int, RestRecord]], triad: str) -> TriadRests | None:
    """Estimate one triad's rate in every rest that holds it, as `dwell_rates`; None if none does."""
    found = _holding(rests, triad)
    return TriadRests(found, *_estimated(found, triad)[:3]) if found else None


def _holding(steps: Sequence[tuple[int, Step]], triad: str) -> tuple[tuple[int, Step], ...]:
    return tuple((number, step) for number, step in steps if channel(step.series, triad) is not None)


def _estimated(
    steps: Sequence[tuple[int, DwellRecord | RestRecord]], triad: str
) -> tuple[FloatArray, FloatArray, FloatArray, tuple[tuple[RateEstimate, ...], ...]]:
    """Return rates (n, 3), 1 sigma (n, 3), white noise (3,) and the estimates, campaign by campaign."""
    estimates = list[tuple[RateEstimate, ...]]()
    for number in dict.fromkeys(n for n, _ in steps):
        records = [record for n, record in steps if n == number]
        estimates += zip(*_triad_rates(records, triad), strict=True)
    rate = np.array([[e.rate for e in row] for row in estimates])
    std = np.array([[e.std for e in row] for row in estimates])
    noise = np.sqrt(np.mean([[e.noise**2 for e in row] for row in estimates], axis=0))
    return rate, std, noise, tuple(estimates)


def _triad_rates(records: Sequence[DwellRecord | RestRecord], triad: str) -> list[list[RateEstimate]]:
    """Return the estimates of each record, by axis."""
    for record in records:
        if len(record.series) < MIN_DWELL_SAMPLES:
            raise TooShort(record.name, len(record.series), MIN_DWELL_SAMPLES)
    period = float(np.median([record.series.period for record in records]))
    counts = isinstance(records[0].series, CountSeries)
    triads = [np.asarray(channel(record.series, triad)) for record in records]
    axes = [[samples[:, axis] for samples in triads] for axis in range(3)]
    quiet = [_quiet(samples, counts) for samples in axes]
    if counts:
        found = _of_quiet(records, axes, quiet, period)
    else:
        pairs = zip(axes, quiet, strict=True)
        found = [estimate_rates([samples[i] for i in those], period) for samples, those in pairs]
    estimates = [dict(zip(those, rates, strict=True)) for those, rates in zip(quiet, found, strict=True)]
    for samples, one, rates in zip(axes, estimates, found, strict=True):
        shared = float(np.mean([each.noise for each in rates])) * np.sqrt(period)
        for i in set(range(len(records))) - one.keys():
            values = samples[i].astype(np.float64)
            one[i] = _of_shaken(values, records[i].series, period, counts, shared)
    return [[one[i] for i in range(len(records))] for one in estimates]


def _quiet(samples: Sequence[FloatArray], counts: bool) -> tuple[int, ...]:
    """Return the numbers of the steps in which nothing shook a channel, ``samples`` (n,) of each."""
    is_shaken = shaken(samples, 1.0 if counts else 0.0)
    if any(is_shaken) and not counts:
        is_shaken = shaken(samples, output_step(samples))
    return tuple(i for i, so in enumerate(is_shaken) if not so)


def _of_quiet(
    records: Sequence[DwellRecord | RestRecord],
    axes: Sequence[Sequence[FloatArray]],
    quiet: Sequence[tuple[int, ...]],
    period: float,
) -> list[list[RateEstimate]]:
    """Estimate the axes' counts in their quiet steps, those that share them side by side."""
    found = dict[int, list[RateEstimate]]()
    for those in dict.fromkeys(quiet):
        alike = [axis for axis, its in enumerate(quiet) if its == those]
        series = [records[i].series for i in those]
        channels = [[axes[axis][i].astype(np.int64, copy=False) for i in those] for axis in alike]
        rates = estimate_channels(channels, period, [s.starts for s in series], [s.t for s in series])
        found |= dict(zip(alike, rates, strict=True))
    return [found[axis] for axis in range(len(axes))]


def _of_shaken(values: FloatArray, series: Series, period: float, counts: bool, shared: float) -> RateEstimate:
    """Return the rate of a channel's samples (n,) less their lines; ``shared`` is the noise of the others."""
    still = without_lines(values)
    if counts:
        return estimate_dithered(still, series.t, series.starts, period, count_noise(still, shared))
    return estimate_rates([still], period)[0]


@dataclass(frozen=True, slots=True, eq=False)
class TurnTotal:
    """A closed turn: the integral of the gyro's output (3,) and its 1 sigma without closure and bias; its time."""

    campaign: int
    record: TurnRecord
    total: FloatArray
    std: FloatArray
    seconds: float
    counts: bool


def turn_totals(campaigns: Sequence[Campaign], noise: FloatArray) -> list[TurnTotal]:
    """Integrate the gyro over every turn; ``noise`` (3,) is the white noise [output/sqrt(s)] of the dwells.

    A counter's total is off by the difference of two remainders, variance 1/6; a rate's only by noise.
    """
    found = []
    for number, campaign in enumerate(campaigns):
        for turn in campaign.turns:
            samples = channel(turn.series, "gyroscope")
            if samples is None:
                continue
            counts = isinstance(turn.series, CountSeries)
            total = samples.sum(axis=0) * (1.0 if counts else turn.series.period)
            seconds = len(samples) * turn.series.period
            variance = noise**2 * seconds + (len(turn.series.starts) / 6 if counts else 0.0)
            found.append(
                TurnTotal(number, turn, np.asarray(total, dtype=float), np.sqrt(variance), seconds, counts)
            )
    return found
