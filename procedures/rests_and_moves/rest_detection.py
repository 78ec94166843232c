"""Rests in an unsegmented recording, found by the unit's own noise.

A sample is at rest where a window of one second about it scatters no more than ``multiplier`` times what the
quietest windows of the same recording do, in each triad by itself (variances of x, y, z added). Tedaldi, Pretto,
Menegatti, ICRA 2014, do the same with the accelerometers and the scatter of an initial minute.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.campaign.campaign import RestRecord, SequenceRecord
from procedures.counts.count_rate import MIN_DWELL_SAMPLES
from procedures.counts.sample_records import CountSeries, Series, series_rows
from procedures.statistics.tail_probabilities import log_chi2_sf

WINDOW_S = 1.0
MIN_REST_S = 1.0  # of samples whose whole window is quiet: two seconds of stillness
MIN_REST_SHARE = 0.1  # share of a recording that is at rest at the least
PARTS = 4  # of a rest, whose means are compared
MOST_MOTION_G = 3e-3  # g: 0.2 deg of tilt or 0.03 m/s2; bias instability of a cheap sensor is a tenth of it
MAX_LOG_P = np.log(0.01)  # that noise alone makes the parts of rests differ
QUIET_VARIANCE_SPREAD = 2.0  # of the quiet windows' variance: 300 samples scatter it by 8 %, hands by a hundred


@dataclass(frozen=True, slots=True, eq=False)
class ScatterLevel:
    """How much each sample's window (n,) scatters, in terms of the quietest; infinite near an end or gap."""

    series: Series
    level: FloatArray

    def rests(self, multiplier: float) -> list[slice]:
        """Return the stretches of samples at rest, in order."""
        quiet = np.concatenate(([False], self.level <= multiplier, [False]))
        edges = np.flatnonzero(np.diff(quiet)).reshape(-1, 2)
        least = max(MIN_REST_S / self.series.period, MIN_DWELL_SAMPLES)
        return [slice(int(begin), int(end)) for begin, end in edges if end - begin >= least]


@np.errstate(all="ignore")  # what overflows is no rest
def scatter_level(series: Series) -> ScatterLevel:
    """Measure how much every sample's window scatters beside the quietest windows of the recording."""
    half = max(round(WINDOW_S / series.period / 2), 4)
    level = np.full(len(series), np.inf)
    for begin, end in zip(series.starts, [*series.starts[1:], len(series)], strict=True):
        if end - begin > 2 * half:
            level[begin + half : end - half] = 0.0
    inside = np.isfinite(level)
    for samples in (series.accel, series.gyro):
        if samples is None or not inside.any():
            continue
        variance = _window_variance(np.asarray(samples, dtype=np.float64), half, inside)
        level[inside] = np.maximum(level[inside], variance / _quiet(variance))
    return ScatterLevel(series, level)


def _window_variance(samples: FloatArray, half: int, inside: BoolArray) -> FloatArray:
    """Return the variance of x, y and z together in the window about every sample that is ``inside``."""
    centred = samples - samples.mean(axis=0)
    sums = [np.concatenate((np.zeros((1, 3)), np.cumsum(centred**power, axis=0))) for power in (1, 2)]
    at: IntArray = np.flatnonzero(inside)
    width = 2 * half + 1
    mean, square = ((total[at + half + 1] - total[at - half]) / width for total in sums)
    variance: FloatArray = np.maximum(square - mean**2, 0.0).sum(axis=1)
    return variance


def _quiet(variance: FloatArray) -> float:
    """Return the variance of windows at rest; the least there is, where none moves; nan where all overflow."""
    low = variance[variance <= QUIET_VARIANCE_SPREAD * float(np.quantile(variance, MIN_REST_SHARE))]
    return max(float(np.median(low)), float(np.finfo(np.float64).tiny)) if len(low) else np.nan


def rests_of(sequence: SequenceRecord, stretches: list[slice]) -> tuple[RestRecord, ...]:
    """Return the stretches of a sequence as rests, named by their number and time."""
    series, whole = sequence.series, np.zeros(1, np.int64)
    return tuple(
        RestRecord(f"{sequence.name} rest {k} ({series.t[s.start]:.1f} s)", None, series_rows(series, s, whole))
        for k, s in enumerate(stretches, 1)
    )


def whole_seconds(t: FloatArray) -> IntArray:
    """Return in which second (n,) since the first each of the times ``t`` (n,) [s] lies."""
    seconds: IntArray = np.floor(t - t[0]).astype(np.int64)
    return seconds


def second_means(second: IntArray, values: FloatArray) -> FloatArray:
    """Return the mean (s, 3) of ``values`` (n, 3), any unit, in each ``second`` (n,); 0 in one without samples."""
    sums = np.stack([np.bincount(second, values[:, axis]) for axis in range(3)], axis=1)
    return sums / np.maximum(np.bincount(second), 1)[:, None]


def motion_within(rests: Sequence[RestRecord], k: FloatArray) -> float | None:
    """Return by how much the parts of the middle rest differ beyond noise [g], None where that is a rest.

    A unit that rests puts out a constant and noise. By the noise between neighbouring samples the means of a
    rest's parts scatter so much and no more; what a hand, a vehicle or a slow turn does is slower, and shows.

    Parameters
    ----------
    rests, k : rests with accelerometers, and their scale factors (3,) [output/s per g]
    """
    more, squares, dof = list[float](), 0.0, 0
    for rest in rests:
        if rest.series.accel is None or len(rest.series) < 2 * PARTS:
            continue
        per = rest.series.period if isinstance(rest.series, CountSeries) else 1.0
        samples = np.asarray(rest.series.accel, dtype=np.float64) / (k * per)
        size = len(samples) // PARTS
        means = samples[: size * PARTS].reshape(PARTS, size, 3).mean(axis=1)
        noise = np.maximum(np.var(np.diff(samples, axis=0), axis=0) / 2 / size, np.finfo(float).tiny)
        variance = np.var(means, axis=0, ddof=1)
        more.append(float(np.sum(np.maximum(variance - noise, 0.0))))
        squares, dof = squares + float(np.sum((PARTS - 1) * variance / noise)), dof + 3 * (PARTS - 1)
    moved = float(np.sqrt(np.median(more))) if more else 0.0
    return moved if moved > MOST_MOTION_G and log_chi2_sf(squares, dof) < MAX_LOG_P else None
