"""What a campaign's steps say, reduced to a rate per dwell and a total per turn, each with its sigma."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, TurnRecord
from procedures.counts.count_rate import MIN_DWELL_SAMPLES, RateEstimate, estimate_channels, estimate_dithered
from procedures.counts.rate_output_mean import estimate_rates, output_step
from procedures.counts.sample_records import CountSeries, Series
from procedures.counts.shaken_dwells import count_noise, shaken, without_lines
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


def _triad_rates(dwells: Sequence[DwellRecord | RestRecord], triad: str) -> list[list[RateEstimate]]:
    """Estimate a triad's rate in each of several dwells, axis by axis."""
    for dwell in dwells:
        if len(dwell.series) < MIN_DWELL_SAMPLES:
            raise TooShort(dwell.name, len(dwell.series), MIN_DWELL_SAMPLES)
    whole = [np.asarray(channel(d.series, triad)) for d in dwells]
    axes = [[samples[:, axis] for samples in whole] for axis in range(3)]
    period = float(np.median([d.series.period for d in dwells]))
    counts = isinstance(dwells[0].series, CountSeries)
    quiet = [_quiet(samples, counts) for samples in axes]
    found = _of_counts(dwells, axes, quiet, period) if counts else _of_rates(axes, quiet, period)
    for samples, still, estimates in zip(axes, quiet, found, strict=True):
        shared = float(np.mean([estimates[i].noise for i in still])) * np.sqrt(period)
        for i in set(range(len(dwells))) - set(still):
            estimates[i] = _of_shaken(samples[i].astype(np.float64), dwells[i].series, period, counts, shared)
    return [[estimates[i] for i in range(len(dwells))] for estimates in found]


def _quiet(samples: Sequence[FloatArray], counts: bool) -> tuple[int, ...]:
    """Return the numbers of a channel's dwells (n,) each that nothing shook."""
    is_shaken = shaken(samples, 1.0 if counts else 0.0)
    if any(is_shaken) and not counts:
        is_shaken = shaken(samples, output_step(samples))
    return tuple(i for i, so in enumerate(is_shaken) if not so)


def _of_counts(
    dwells: Sequence[DwellRecord | RestRecord], axes: Sequence[Sequence[FloatArray]],
    quiet: Sequence[tuple[int, ...]], period: float,
) -> list[dict[int, RateEstimate]]:  # fmt: skip
    """Return each axis' estimates by dwell; axes of which the same dwells are quiet are estimated side by side."""
    found: list[dict[int, RateEstimate]] = [{} for _ in axes]
    for still in dict.fromkeys(quiet):
        alike = [axis for axis, others in enumerate(quiet) if others == still]
        series = [dwells[i].series for i in still]
        channels = [[axes[axis][i].astype(np.int64, copy=False) for i in still] for axis in alike]
        rates = estimate_channels(channels, period, [s.starts for s in series], [s.t for s in series])
        for axis, estimates in zip(alike, rates, strict=True):
            found[axis] = dict(zip(still, estimates, strict=True))
    return found


def _of_rates(
    axes: Sequence[Sequence[FloatArray]], quiet: Sequence[tuple[int, ...]], period: float
) -> list[dict[int, RateEstimate]]:
    return [
        dict(zip(still, estimate_rates([samples[i] for i in still], period), strict=True))
        for samples, still in zip(axes, quiet, strict=True)
    ]


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
