"""Straight lines through points with correlated errors, and through time stamps of which some are late or wrong.

`fit_correlated_line` takes the errors for white noise and an Ornstein-Uhlenbeck process in unknown parts and with
unknown memory. Each such noise gives a line by generalised least squares; they are averaged, weighted by their
restricted likelihood (Patterson and Thompson 1971). Where points come in records, an offset of each record's own
is among the noises. An offset may also begin between any two points: against none a step is weighed by its Bayes
factor in each noise (Zellner and Siow 1980: its size is Cauchy distributed beforehand, by the information of one
point). While no step is certain the sigma holds the lines without one, and those with one as if it were as
credible as none.

`fit_time_line` goes through the middle of marks of two clocks, `fit_earliest_line` along those that came least
late: their delays move with all that the machine has to do, the least of them hardly.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.statistics.significance import robust_std

MEMORIES_TRIED = 5  # tried, from the distance of points to their span
CORRELATED_SHARES_TRIED = (0.3, 0.6, 0.9)  # of the variance that remembers
RECORD_SHARES_TRIED = (0.9, 0.99, 0.999, 0.9999, 1 - 1e-6)  # of the variance that is each record's own offset
RECORD_SLOPES_TRIED = (1.0, 10.0, 100.0, 1e3, 1e4)  # times the variance within records: each one's own slope
# Times as credible beforehand as any noise with memory: noise without, offsets of records
WHITE_PRIOR_ODDS, RECORD_PRIOR_ODDS = 4.0, 0.3
MIN_FREE_POINTS = 3  # points beyond the coefficients
STEP_PRIOR_ODDS = 1e-3  # times as credible beforehand as no step: one at any place
CERTAIN_STEP_PROBABILITY = 0.999  # probability of a step at one place
# Squares of a step's size beforehand, by the information of one point
STEP_SIZES_SQUARED = np.geomspace(1e-2, 1e8, 61)


@dataclass(frozen=True, slots=True)
class CorrelatedLine:
    """A slope, its 1 sigma, and the degrees of freedom behind it; ``step`` is the point at which one surely is."""

    slope: float
    std: float
    dof: float
    step: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """Log credibility, slope and variance (s, m) of lines: without a step first, then with one at each place."""

    log: FloatArray
    slope: FloatArray
    variance: FloatArray


def fit_correlated_line(
    x: FloatArray, y: FloatArray, group: IntArray, least: float = 0.0, record: IntArray | None = None
) -> CorrelatedLine | None:
    """Fit one slope and an offset for each group; None for too few points.

    Parameters
    ----------
    x, y : (n,), any units; points of a group are in order
    group : (n,), its number for each point
    least : the 1 sigma that a point has at the least, in the unit of y
    record : (n,), a number for each point; the offset may be another in each. Default: all are of one
    """
    n, span = len(x), float(np.ptp(x))
    _, member = np.unique(group, return_inverse=True)
    design = np.column_stack([np.eye(int(member.max(initial=0)) + 1)[member], (x - x.mean()) / (span or 1.0)])
    dof = n - design.shape[1]
    if dof < MIN_FREE_POINTS or not span > 0:
        return None
    places, steps = _steps(member) if dof > MIN_FREE_POINTS else (np.zeros(0, dtype=np.int64), np.zeros((n, 0)))
    d, V = _noises(np.abs(x[:, None] - x) / span)
    without = len(d)
    if record is not None and _determine_a_slope(record, member):
        d, V = (np.concatenate(each) for each in zip((d, V), _offsets_of_records(x, record), strict=True))
    found = _fit(d, V @ design, V @ y, V @ steps, least)
    log, slope, variance = found.log, found.slope, found.variance
    log[0] += np.log(WHITE_PRIOR_ODDS)
    log[without:] += np.log(RECORD_PRIOR_ODDS)
    share = np.exp(log - log.max())
    share /= share.sum()
    mean, at = float((share * slope).sum()), share.sum(axis=0)[1:]
    step = int(places[at.argmax()]) if at.max(initial=0.0) > CERTAIN_STEP_PROBABILITY else None
    even = log - np.log(STEP_PRIOR_ODDS) * (np.arange(log.shape[1]) > 0)
    held = [log] if step is not None else [log, np.where(np.arange(log.shape[1]) > 0, -np.inf, log), even]
    std = max(_std_about(mean, each, slope, variance) for each in held)
    return CorrelatedLine(mean / span, std / span, float(dof - at.sum()), step)


def _noises(apart: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the noises tried: variances (s, n) along the rows of V (s, n, n); the first has no memory."""
    memories = np.geomspace(1 / len(apart), 1.0, MEMORIES_TRIED)
    w, V = np.linalg.eigh(np.exp(-apart / memories[:, None, None]))
    part = np.array(CORRELATED_SHARES_TRIED)[:, None]
    d = 1 - part + part * np.maximum(w, 0.0)[:, None]
    turns = np.repeat(V.swapaxes(1, 2), len(part), axis=0)
    n = len(apart)
    return np.vstack((np.ones(n), d.reshape(-1, n))), np.concatenate((np.eye(n)[None], turns))


def _determine_a_slope(record: IntArray, member: IntArray) -> bool:
    """Say whether points within records give a slope, and a group has several: else its offset holds theirs."""
    pairs = np.unique(np.stack((record, member)), axis=1)
    return bool(len(np.unique(pairs[1])) < pairs.shape[1] < len(record))


def _offsets_of_records(x: FloatArray, record: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the noises of offsets that are each record's own, or walk from one to the next, as `_noises` does.

    After them those of offsets and slopes that are each record's own.
    """
    _, index = np.unique(record, return_inverse=True)
    own, walked = index[:, None] == index, np.minimum(index[:, None], index) / max(float(np.mean(index)), 1.0)
    share = np.array(RECORD_SHARES_TRIED)
    from_middle = x - (np.bincount(index, x) / np.bincount(index))[index]
    bent = own * np.outer(from_middle, from_middle) / max(float(np.mean(from_middle**2)), np.finfo(float).tiny)
    slopes = own + (1 - share[-1]) * np.array(RECORD_SLOPES_TRIED)[:, None, None] * bent
    w, V = np.linalg.eigh(np.concatenate((np.repeat([own, walked], len(share), axis=0), slopes)))
    part = np.concatenate((share, share, np.full(len(slopes), share[-1])))[:, None]
    return 1 - part + part * np.maximum(w, 0.0), V.swapaxes(1, 2)


def _std_about(mean: float, log: FloatArray, slope: FloatArray, variance: FloatArray) -> float:
    """Return 1 sigma about a value of slopes (m, s), each as credible as the exponential of ``log`` (m, s)."""
    weight = np.exp(log - log.max())
    return float(np.sqrt((weight * (variance + (slope - mean) ** 2)).sum() / weight.sum()))


def _steps(member: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the points (m,) at which an offset may begin, and what it adds to all points (n, m)."""
    index = np.arange(len(member))
    places = np.array([i for i in index if (member[:i] == member[i]).any()], dtype=np.int64)
    return places, ((index[:, None] >= places) & (member[:, None] == member[places])).astype(float)


def _fit(d: FloatArray, design: FloatArray, y: FloatArray, steps: FloatArray, least: float) -> _Lines:
    """Fit lines without and with each step for errors of covariance diag(d) s^2, one for each row of d (s, n)."""
    n, k = design.shape[1:]
    root = np.sqrt(d)[..., None]
    X, v, S = design / root, y[..., None] / root, steps / root
    normal = X.mT @ X
    inverse = np.linalg.inv(normal)
    b, across = inverse @ (X.mT @ v), inverse @ (X.mT @ S)
    residual, apart = v - X @ b, S - X @ across
    square, size = (residual**2).sum(axis=1), np.maximum((apart**2).sum(axis=1), np.finfo(float).tiny)
    by = (apart.mT @ residual)[..., 0] / size
    floor = max(least**2, np.finfo(float).tiny) / d.min(axis=1, keepdims=True)  # what no point shares has it
    total = np.maximum(square, floor * (n - k))
    less = square - by**2 * size
    left = np.maximum(less, floor * (n - k))
    variance = np.maximum(np.maximum(less, 0.0) / max(n - k - 1, 1), floor)
    none = np.log(d).sum(axis=1) + np.linalg.slogdet(normal)[1]
    none = -0.5 * (none[:, None] + (n - k) * np.log(total / (n - k)))
    gain = _bayes_factor(left / total, n, n - k) + np.log(STEP_PRIOR_ODDS / max(steps.shape[2], 1))
    of_slope, with_step = inverse[:, -1:, -1], across[:, -1]
    return _Lines(
        np.hstack((none, none + gain)),
        np.hstack((b[:, -1], b[:, -1] - with_step * by)),
        np.hstack((total / (n - k) * of_slope, variance * (of_slope + with_step**2 / size))),
    )


def _bayes_factor(left: FloatArray, n: int, dof: int) -> FloatArray:
    """Return the log Bayes factors (s, m) of one more coefficient that leaves this share of the squares (s, m)."""
    g, log_prior, before = _step_sizes(n)
    each = log_prior + 0.5 * (dof - 1) * np.log1p(g) - 0.5 * dof * np.log1p(g * left[..., None])
    most = each.max(axis=-1, keepdims=True, initial=-np.inf)
    factor: FloatArray = np.log(np.exp(each - most).sum(axis=-1)) + most[..., 0] - before
    return factor


@lru_cache(maxsize=8)
def _step_sizes(n: int) -> tuple[FloatArray, FloatArray, float]:
    """Return g, its log credibility beforehand, and the log of that one's sum."""
    g = n * STEP_SIZES_SQUARED
    log_prior = -0.5 * np.log(g) - 0.5 * n / g  # inverse gamma (1/2, n/2), over log g
    return g, log_prior, float(np.log(np.exp(log_prior).sum()))


MIN_MARKS = 6  # marks
MAX_STRETCHES = 32
# Scatters, and seconds of the clock, that a mark may be before the middle ones
MAX_AHEAD_SCATTERS, MAX_AHEAD_S = 8.0, 0.05


@dataclass(frozen=True, slots=True)
class TimeLine:
    """``reference = reference_0 + rate (clock - clock_0)``, both ends in ns.

    ``scatter`` [s] is the robust 1 sigma of one mark about the line.
    """

    clock_0: int
    reference_0: int
    rate: float
    scatter: float

    def at(self, clock_ns: int) -> float:
        """Return the reference [s] at a moment of the clock [ns]."""
        return self.reference_0 / 1e9 + self.rate * (clock_ns - self.clock_0) / 1e9

    def when(self, reference_ns: int) -> int:
        """Return the moment of the clock [ns] at which the reference says so [ns]."""
        return self.clock_0 + round((reference_ns - self.reference_0) / self.rate)


def fit_time_line(clock_ns: IntArray, reference_ns: IntArray) -> TimeLine | None:
    """Fit a line to marks ``clock_ns``, ``reference_ns`` (n,) [ns] of two clocks, the first in order.

    None where they are too few. The slope is the median between the medians of up to 32 stretches (Theil and Sen),
    the offset the marks' median.
    """
    if len(clock_ns) < MIN_MARKS or clock_ns[-1] <= clock_ns[0]:
        return None
    x, y = (clock_ns - clock_ns[0]) / 1e9, (reference_ns - reference_ns[0]) / 1e9
    stretches = np.array_split(np.arange(len(x)), min(MAX_STRETCHES, len(x)))
    centre: FloatArray = np.array([[np.median(x[s]), np.median(y[s])] for s in stretches])
    rate = median_slope(*centre.T)
    if rate is None:
        return None
    left = y - rate * x
    offset = float(np.median(left))
    return TimeLine(int(clock_ns[0]), int(reference_ns[0]) + round(offset * 1e9), rate, robust_std(left))


def median_slope(x: FloatArray, y: FloatArray, group: IntArray | None = None) -> float | None:
    """Return the median slope between all pairs of points of one group, None if there are none (Theil and Sen).

    Parameters
    ----------
    x, y : (n,), of any unit
    group : (n,), of each point; None if all are of one
    """
    i, j = np.triu_indices(len(x), 1)
    usable = x[j] > x[i] if group is None else (group[i] == group[j]) & (x[j] > x[i])
    return float(np.median((y[j] - y[i])[usable] / (x[j] - x[i])[usable])) if usable.any() else None


def fit_earliest_line(clock_ns: IntArray, reference_ns: IntArray) -> TimeLine | None:
    """Fit a line to marks ``clock_ns``, ``reference_ns`` (n,) [ns], read late by the clock, never early.

    None where they are too few. No mark lies above it but those that are far ahead of the middle ones, as of a
    reference that was set wrong for a while: it is the edge of the marks' convex hull over their mean.
    """
    line = fit_time_line(clock_ns, reference_ns)
    if line is None:
        return None
    x, y = (clock_ns - clock_ns[0]) / 1e9, (reference_ns - reference_ns[0]) / 1e9
    off = y - line.rate * x
    off -= np.median(off)
    keep = off <= max(MAX_AHEAD_SCATTERS * line.scatter, MAX_AHEAD_S * line.rate)
    x, off = x[keep], off[keep]
    hull = _upper_hull(x, off)
    right = min(max(int(np.searchsorted(x[hull], x.mean())), 1), len(hull) - 1)
    a, b = hull[right - 1], hull[right]
    slope = float((off[b] - off[a]) / (x[b] - x[a]))
    middle = float(np.median(y - line.rate * (clock_ns - clock_ns[0]) / 1e9))
    offset = middle + float(off[a] - slope * x[a])
    return TimeLine(int(clock_ns[0]), int(reference_ns[0]) + round(offset * 1e9), line.rate + slope, line.scatter)


def _upper_hull(x: FloatArray, y: FloatArray) -> list[int]:
    """Return the points of the upper convex hull of points in order of x; of equal x the highest."""
    hull = list[int]()
    for i in range(len(x)):
        if hull and x[i] == x[hull[-1]]:
            if y[i] <= y[hull[-1]]:
                continue
            hull.pop()
        while len(hull) > 1 and _is_below(x, y, hull[-2], hull[-1], i):
            hull.pop()
        hull.append(i)
    return hull


def _is_below(x: FloatArray, y: FloatArray, a: int, b: int, c: int) -> bool:
    return bool((y[b] - y[a]) * (x[c] - x[a]) <= (y[c] - y[a]) * (x[b] - x[a]))
