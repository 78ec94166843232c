"""Rests in an unsegmented recording, found by the unit's own noise; whether it moves or turns at all.

A sample is at rest where a window of one second about it scatters no more than ``multiplier`` times what the
quietest windows of the same recording do, in each triad by itself (variances of x, y, z added; Tedaldi, Pretto,
Menegatti, ICRA 2014, have the scatter of an initial minute).

The accelerometers show no turn about the vertical. A gyroscope whose unit is known does (`turning`): its medians
of a second lie far from rest for more than a moment, and come there fast.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray, true_runs
from procedures.campaign.campaign import RestRecord, SequenceRecord
from procedures.counts.count_rate import MIN_DWELL_SAMPLES
from procedures.counts.sample_records import CountSeries, Series, series_rows
from procedures.statistics.significance import STD_PER_MAD, log_chi2_sf

WINDOW_S = 1.0
MIN_REST_S = 1.0  # of samples whose whole window is quiet: two seconds of stillness
MIN_REST_SHARE = 0.1  # share of a recording that is at rest at the least
RESTLESS = 2.0  # times the multiplier, from which on a rest has ended
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
        """Return the stretches of samples at rest, in order.

        One goes on where noise alone lifts its level for a moment: motion lifts it by far more.
        """
        edges = [
            (begin, end)
            for begin, end in true_runs(self.level <= RESTLESS * multiplier)
            if np.any(self.level[begin:end] <= multiplier)
        ]
        least = max(MIN_REST_S / self.series.period, MIN_DWELL_SAMPLES)
        return [slice(int(begin), int(end)) for begin, end in edges if end - begin >= least]


@np.errstate(all="ignore")  # what overflows is no rest
def scatter_level(series: Series) -> ScatterLevel:
    """Measure how much every sample's window scatters, relative to the quietest windows of the recording."""
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


MOVED_LEVEL = 30.0  # times the variance of the quietest windows: no noise that is merely uneven
TURNED = 0.1  # of 1 g: 6 deg of the vertical
# Where 1 g is not known a move must change the output by more than rests change, and than samples scatter
TIMES_DRIFT, TIMES_NOISE = 20.0, 20.0
# Of a scale factor that was calibrated once: a gyroscope that turned farther from whole turns turned by another
# angle, or is not calibrated, and nothing in the recording shows which
MAX_SCALE_ERROR = 0.005


def moves_and_rests(series: Series, outputs_per_g: float | None = None) -> bool:
    """Say whether the accelerometers rest in two attitudes at least and move in between.

    ``outputs_per_g`` is their nominal scale factor, where it is known.
    """
    if series.accel is None:
        return False
    samples = np.asarray(series.accel, dtype=np.float64)
    rests = scatter_level(series).rests(MOVED_LEVEL)
    if len(rests) < 2:
        return False
    means = np.array([samples[rest].mean(axis=0) for rest in rests])
    apart = np.linalg.norm(np.diff(means, axis=0), axis=1)
    if outputs_per_g is not None:
        return bool(np.max(apart) > TURNED * outputs_per_g)
    halves = [np.array_split(samples[rest], 2) for rest in rests]
    drift = float(np.median([np.linalg.norm(b.mean(axis=0) - a.mean(axis=0)) for a, b in halves]))
    noise = float(np.median([np.linalg.norm(samples[rest].std(axis=0)) for rest in rests]))
    return bool(np.max(apart) > max(TIMES_DRIFT * drift, TIMES_NOISE * noise))


def turned_deg(series: Series, axis: int, outputs_per_deg_s: float) -> float:
    """Return by how many degrees a series turned about sensor ``axis``, above the rate at both its ends."""
    if series.gyro is None:
        return 0.0
    rate = np.asarray(series.gyro[:, axis], dtype=np.float64)
    end = max(len(rate) // 20, 1)
    rest = np.median(np.concatenate((rate[:end], rate[-end:])))
    return float(np.sum(rate - rest)) * series.period / outputs_per_deg_s


def true_angle(
    turned_deg: float, beyond_deg: float = 0.0, scale_error: float = MAX_SCALE_ERROR, slack_deg: float = 0.0
) -> float | None:
    """Return the angle ``beyond_deg`` + 360 n that a gyroscope turned by; None where no n fits, or more than one.

    An angle fits where the gyroscope is within ``scale_error`` of it, relative, or within ``slack_deg`` [deg].
    """
    if not np.isfinite(turned_deg):
        return None
    turned, sign = abs(turned_deg), -1 if turned_deg < 0 else 1
    low = min(turned / (1 + scale_error), turned - slack_deg)
    high = max(turned / (1 - scale_error), turned + slack_deg)
    first, last = np.ceil((low - sign * beyond_deg) / 360), np.floor((high - sign * beyond_deg) / 360)
    return float(beyond_deg + sign * 360 * first) if first == last else None


def whole_turns(turned_deg: float) -> int | None:
    """Return the whole revolutions that an angle by a gyroscope is; None where it is not surely that many."""
    angle = true_angle(turned_deg)
    return round(abs(angle) / 360) if angle else None


MEDIAN_S, MEDIAN_SAMPLES = 1.0, 5  # whichever is longer
LEAST_RATE = 1.0  # deg/s beyond rest: no drift or jump of a unit at rest in any but seconds of it
LEAST_SHARE = 0.02  # of the recording
LEAST_ANGLE = 10.0  # deg in all
NOISE_SIGMAS = 8.0  # of a mean of as many samples: a median scatters by a quarter more
FAST_S, LEAST_CHANGES = 10.0, 2  # within which a turn begins or ends, and how many of these there are
ANY_WAY = 10.0  # deg/s: no bias, however it got there
MIN_SOAK_REST_S = 10.0


@dataclass(frozen=True, slots=True)
class Turning:
    """By how much a recording turned at most [deg/s], about which sensor and in which sense (1, -1).

    ``rest`` is its longest stretch at rest; None where no rest is longer than `MIN_SOAK_REST_S`.
    """

    axis: int
    sign: int
    fastest: float
    rest: slice | None


def turning(series: Series, outputs_per_deg_s: float | None) -> Turning | None:
    """Say whether and how a recording turned; None where it did not, or nobody stated the gyroscopes' unit."""
    if series.gyro is None or not outputs_per_deg_s:
        return None
    rate = np.asarray(series.gyro, dtype=np.float64) / outputs_per_deg_s
    size = max(round(MEDIAN_S / series.period), MEDIAN_SAMPLES)
    if len(rate) < 2 * size:
        return None
    whole = len(rate) // size * size
    middles: FloatArray = np.median(rate[:whole].reshape(-1, size, 3), axis=1)
    beyond = middles - _at_rest(middles)
    least = np.maximum(LEAST_RATE, NOISE_SIGMAS * _noise(rate) / np.sqrt(size))
    turns = np.abs(beyond) > least
    seconds = size * series.period
    axis = int(np.argmax(np.sum(np.abs(beyond) * turns, axis=0)))
    if not _is_turn(beyond[:, axis], turns[:, axis], seconds):
        return None
    first = beyond[np.argmax(turns[:, axis]), axis]
    fastest = float(np.max(np.abs(beyond[:, axis])))
    return Turning(axis, 1 if first > 0 else -1, fastest, _longest(~turns.any(axis=1), size, seconds))


def _at_rest(middles: FloatArray) -> FloatArray:
    """Return what the gyroscopes put out at rest (3,) [deg/s]: the median of what may be a bias."""
    near = np.abs(middles - np.median(middles, axis=0)) < ANY_WAY
    slow = np.abs(middles) < ANY_WAY
    chosen = np.where(slow.any(axis=0), slow, near)
    return np.nanmedian(np.where(chosen, middles, np.nan), axis=0)


def _noise(rate: FloatArray) -> FloatArray:
    """Return 1 sigma (3,) of a sample's noise, by second differences, in which motion cancels."""
    found: FloatArray = STD_PER_MAD * np.median(np.abs(np.diff(rate, 2, axis=0)), axis=0) / np.sqrt(6)
    return found


def _is_turn(beyond: FloatArray, turns: BoolArray, seconds: float) -> bool:
    if turns.mean() <= LEAST_SHARE or np.sum(np.abs(beyond[turns])) * seconds < LEAST_ANGLE:
        return False
    if np.mean(np.abs(beyond) > ANY_WAY) > LEAST_SHARE:
        return True
    lag = max(round(FAST_S / seconds), 1)
    fast = np.abs(beyond[lag:] - beyond[:-lag]) > LEAST_RATE
    # a change is seen for as long as `FAST_S`; of several that run into each other each counts
    changes = sum(max(1, round((end - begin) / lag)) for begin, end in true_runs(fast))
    return bool(changes >= LEAST_CHANGES)


def _longest(rests: BoolArray, size: int, seconds: float) -> slice | None:
    """Return the longest stretch at rest as samples, without the seconds in which a turn may begin or end."""
    edges = true_runs(rests)
    edges[:, 0] += edges[:, 0] > 0
    edges[:, 1] -= edges[:, 1] < len(rests)
    length = edges[:, 1] - edges[:, 0]
    if not len(length) or length.max() * seconds < MIN_SOAK_REST_S:
        return None
    begin, end = edges[int(np.argmax(length))].tolist()
    return slice(begin * size, end * size)
