"""Does a gyroscope's output say that the recording turned? Then only what rests in it is a soak.

The accelerometers tell no turn about the vertical (`moving`). A gyroscope whose unit is told does, by its medians
of a second: they lie far from rest for more than a moment, and come there fast. A drift comes slowly, a jump comes
once and is small, wrong rows move no median.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_records import Series

MEDIAN_S, MEDIAN_SAMPLES = 1.0, 5  # whichever is longer
LEAST_RATE = 1.0  # deg/s beyond rest: no drift or jump of a unit at rest in any but seconds of it
LEAST_SHARE = 0.02  # of the recording
LEAST_ANGLE = 10.0  # deg in all
NOISE_SIGMAS = 8.0  # of a mean of as many samples: a median scatters by a quarter more
FAST_S, LEAST_CHANGES = 10.0, 2  # within which a turn begins or ends, and how many of these there are
ANY_WAY = 10.0  # deg/s: no bias, however it got there
MIN_REST_S = 10.0


@dataclass(frozen=True, slots=True)
class Turning:
    """By how much a recording turned at most [deg/s], about which sensor and in which sense (1, -1).

    ``rest`` is its longest stretch at rest; None where no rest is longer than `MIN_REST_S`.
    """

    axis: int
    sign: int
    fastest: float
    rest: slice | None


def turning(series: Series, outputs_per_deg_s: float | None) -> Turning | None:
    """Say whether and how a recording turned; None where it did not, or nobody told the gyroscopes' unit."""
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
    found: FloatArray = np.nanmedian(np.where(chosen, middles, np.nan), axis=0)
    return found


def _noise(rate: FloatArray) -> FloatArray:
    """Return 1 sigma (3,) of a sample's noise, by second differences, in which motion cancels."""
    found: FloatArray = 1.4826 * np.median(np.abs(np.diff(rate, 2, axis=0)), axis=0) / np.sqrt(6)
    return found


def _is_turn(beyond: FloatArray, turns: BoolArray, seconds: float) -> bool:
    if turns.mean() <= LEAST_SHARE or np.sum(np.abs(beyond[turns])) * seconds < LEAST_ANGLE:
        return False
    if np.mean(np.abs(beyond) > ANY_WAY) > LEAST_SHARE:
        return True
    lag = max(round(FAST_S / seconds), 1)
    fast = np.abs(beyond[lag:] - beyond[:-lag]) > LEAST_RATE
    edges = np.flatnonzero(np.diff(np.concatenate(([False], fast, [False])))).reshape(-1, 2)
    # a change is seen for as long as `FAST_S`; of several that run into each other each counts
    changes = sum(max(1, round((end - begin) / lag)) for begin, end in edges)
    return bool(changes >= LEAST_CHANGES)


def _longest(rests: BoolArray, size: int, seconds: float) -> slice | None:
    """Return the longest stretch at rest as samples, without the seconds in which a turn may begin or end."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], rests, [False])))).reshape(-1, 2)
    edges[:, 0] += edges[:, 0] > 0
    edges[:, 1] -= edges[:, 1] < len(rests)
    length = edges[:, 1] - edges[:, 0]
    if not len(length) or length.max() * seconds < MIN_REST_S:
        return None
    begin, end = edges[int(np.argmax(length))].tolist()
    return slice(begin * size, end * size)
