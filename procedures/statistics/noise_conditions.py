"""Conditions of a recording and their effect on its noise terms: bounds, wider intervals, or undetermined.

White noise of sigma about a mean, rounded to whole steps, falls on level k with probability ``Phi((k + 1/2 - mean)
/ sigma) - Phi((k - 1/2 - mean) / sigma)``: a likelihood, of which the mean of each block of rows is integrated
out. Rows must be independent, which is tested. Two levels only bound sigma from above. From about 0.6 steps on,
rounding adds white noise of variance 1/12 step^2 (Widrow and Kollar, Quantization Noise, 2008), which is
subtracted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import betaincinv, log_ndtr, logsumexp, ndtr, ndtri

from procedures.arrays import FloatArray, IntArray
from procedures.statistics.allan_deviation import (
    TERMS,
    AllanDeviation,
    NoiseFit,
    NoiseTerm,
    fit_noise,
    noise_shapes,
    overlapping_deviation,
)

ALL = TERMS
MAX_LOG_P = -14.0  # ln of the chance of a condition in noise: once in a million recordings
Values = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Condition:
    """Something that was found in the samples of a recording.

    ``name`` is stable, ``text`` a sentence, ``values`` the numbers in it. ``undetermined`` are the noise terms
    (`procedures.statistics.allan_deviation.TERMS`) that such a recording does not determine. ``is_of_recording``:
    it is one of the rows, and holds for every channel of the recording, also where noise hides it.
    """

    name: str
    text: str
    undetermined: tuple[str, ...] = ()
    values: Values = field(default_factory=dict)
    is_of_recording: bool = False


COARSE_STD = 0.6  # steps, of differences over sqrt(2), below which rounding is no added white noise
FINE_STD = 6.0  # steps, from which rounding adds less than 0.25 % of the variance
SIGMAS = np.geomspace(0.01, 1.5, 81)  # steps, looked at
MEANS = 40  # to a step, at the least
PEAK_DEPTH = 12.0  # below the largest ln likelihood of a mean: beyond it are 1e-5 of the integral
MIN_IN_PEAK, PEAK_POINTS, REFINEMENTS = 12, 48, 4  # means within it, of a finer grid; each is 10 times finer
BLOCKS = (1, 4, 16, 64, 256, 1024)
MIN_BLOCK = 32  # rows
MAX_Z = 3.5  # of the correlation of rows within blocks, and of the means of their parts
LOG_RATIO = 2.4  # below the largest ln likelihood: 1.92 is 95 % of many rows, some levels hold two or three
MAX_LEVELS = 12  # in a block


@dataclass(frozen=True, slots=True)
class NoiseOfLevels:
    """The noise of a sample [steps], 95 % limits; ``value`` is None where only ``high``, or nothing, is known."""

    value: float | None
    low: float
    high: float
    levels: int


def short_std(rate: FloatArray, step: float) -> float:
    """Return the noise of ``rate`` (n,) from row to row, in steps of ``step`` (its unit)."""
    return float(np.std(np.diff(rate)) / np.sqrt(2) / step)


def noise_of_levels(rate: FloatArray, step: float) -> NoiseOfLevels:
    """Return the white noise that makes the levels of ``rate`` (n,), ``step`` apart in its unit, as often."""
    level = np.round((rate - rate.min()) / step).astype(np.int64)
    levels = len(np.unique(level))
    high = largest_sigma(level)
    for count in BLOCKS:
        if len(level) < MIN_BLOCK * count:
            break
        size = len(level) // count
        blocks = level[: size * count].reshape(count, size)
        if is_independent(blocks) and int(np.ptp(blocks, axis=1).max()) < MAX_LEVELS:
            if levels < 3 and count == 1:  # the smaller sigma is, the nearer to the edge the mean may be
                return NoiseOfLevels(None, 0.0, high, levels)
            return _by_likelihood(blocks, levels, high)
    return NoiseOfLevels(None, 0.0, np.inf, levels)  # rows hang together: no random walk


def largest_sigma(level: IntArray) -> float:
    """Return the largest sigma [steps] that leaves so many of ``level`` (n,) (numbers) within one or two levels.

    Whatever the mean does: a window of L levels holds at most ``2 Phi(L / (2 sigma)) - 1`` of the rows.
    """
    counts = np.bincount(level)
    found = np.inf
    for width in (1, 2, 3):
        inside = int(np.convolve(counts, np.ones(width, dtype=np.int64)).max())
        outside = len(level) - inside
        share = float(betaincinv(outside + 1, inside, 0.975)) if inside else 1.0
        if share < 1:
            found = min(found, width / 2 / max(float(-ndtri(share / 2)), 1e-9))
    return float(found)


def is_independent(blocks: IntArray) -> bool:
    """Say whether levels in ``blocks`` (b, m) (numbers) are independent from row to row about a block's mean."""
    b, m = blocks.shape
    off = blocks - blocks.mean(axis=1, keepdims=True)
    power = float(np.sum(off**2))
    if power == 0:
        return True
    own = np.sum(off**2, axis=1)
    alive = power**2 / float(own @ own)  # blocks whose levels change, of others nothing is learnt
    for lag in (1, 2, 4):
        r = float(np.sum(off[:, lag:] * off[:, :-lag])) / power + 1 / m
        if abs(r) * np.sqrt(alive * m) > MAX_Z:
            return False
    parts = off[:, : m - m % 4].reshape(b, 4, -1).mean(axis=2)
    excess = float(np.sum(parts**2)) / (power / (b * m) / (m // 4)) - 3 * b  # chi-square of 3 for each block
    return bool(excess < b / alive * (MAX_Z * np.sqrt(6 * alive) + 3 * MAX_Z))


def _by_likelihood(blocks: IntArray, levels: int, high: float) -> NoiseOfLevels:
    """Return the sigma of the largest likelihood and its limits."""
    offset = blocks - blocks.min(axis=1)[:, None]
    span = int(offset.max()) + 1
    counts = np.stack([np.sum(offset == k, axis=1) for k in range(span)], axis=1).astype(np.float64)
    looked = SIGMAS
    for _ in range(2):  # the second time within the limits
        log_likelihood = log_likelihood_of_sigmas(counts, looked)
        best = int(np.argmax(log_likelihood))
        best_sigma = float(looked[best])
        inside = np.flatnonzero(log_likelihood > log_likelihood[best] - LOG_RATIO)
        low, upper = looked[[max(inside[0] - 1, 0), min(inside[-1] + 1, len(looked) - 1)]].tolist()
        if low == SIGMAS[0] or upper == SIGMAS[-1]:
            return NoiseOfLevels(None, 0.0, min(upper, high), levels)
        looked = np.geomspace(low, upper, len(SIGMAS) // 2)
    return NoiseOfLevels(best_sigma, low, upper, levels)


def log_likelihood_of_sigmas(counts: FloatArray, sigmas: FloatArray) -> FloatArray:
    """Return ln of the likelihood of each of ``sigmas`` (s,) [steps] for ``counts`` (b, k) of blocks' levels.

    It is log-concave in a block's mean (Pratt, JASA 1981): a narrow peak is integrated on a finer grid.
    """
    counts, alike = np.unique(counts, axis=0, return_counts=True)
    return np.array([float(alike @ _integrals(counts, float(sigma))) for sigma in sigmas])


def _integrals(counts: FloatArray, sigma: float) -> FloatArray:
    """Return ln of each block's likelihood (b,) integrated over its mean; ``counts`` (b, k), ``sigma`` [steps]."""
    span = counts.shape[1]
    k = np.arange(span)[:, None]
    grid = np.linspace(-1.0, span, int((span + 1) * max(MEANS, 4 / sigma)))  # the finer the smaller sigma is
    found = counts @ _log_interval((k - 0.5 - grid) / sigma, (k + 0.5 - grid) / sigma)
    means, narrow = np.broadcast_to(grid, found.shape), np.arange(len(counts))
    total = np.zeros(len(counts))
    for refinement in range(REFINEMENTS + 1):
        top = found.max(axis=1, keepdims=True)
        step = means[:, 1] - means[:, 0]
        total[narrow] = logsumexp(found, axis=1) + np.log(step)
        within = found > top - PEAK_DEPTH
        again = within.sum(axis=1) < MIN_IN_PEAK
        if not again.any() or refinement == REFINEMENTS:
            break
        rows, last = np.flatnonzero(again), found.shape[1] - 1
        first = np.maximum(np.argmax(within[rows], axis=1) - 1, 0)
        end = np.minimum(last - np.argmax(within[rows, ::-1], axis=1) + 1, last)
        means = np.linspace(means[rows, first], means[rows, end], PEAK_POINTS, axis=1)
        narrow = narrow[rows]
        found = np.zeros(means.shape)
        for level in range(span):
            low, high = (level - 0.5 - means) / sigma, (level + 0.5 - means) / sigma
            found += counts[narrow, level, None] * _log_interval(low, high)
    return total


def _log_interval(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return ln of the standard normal probability (..., n) between numbers ``a`` and ``b`` (..., n)."""
    swap = a > 0
    a, b = np.where(swap, -b, a), np.where(swap, -a, b)
    lower, upper = log_ndtr(a), log_ndtr(b)
    found: FloatArray = np.where(
        b > -3, np.log(np.maximum(ndtr(b) - ndtr(a), 1e-300)),
        upper + np.log1p(-np.exp(np.minimum(lower - upper, -1e-12))),
    )  # fmt: skip
    return found


UNDETERMINED = NoiseTerm(None, 0.0, np.inf)
INTERVAL_BLOCKS = 8  # of rows, whose mean intervals are compared
MIN_INTERVAL_CHANGE, MAX_INTERVAL_CHANGE = 0.02, 2.0  # relative, and the ratio beyond which no term is left
INTERVAL_SIGMAS = 5.0
MIN_STEPS = 64
MIN_STEP_SPREAD, OWN_STEP_SPREAD = 0.15, 0.1  # of the mean step, from row to row; of that, of a device's own steps
TAU_POWERS = dict(zip(TERMS, (1.0, 0.5, 0.0, -0.5, -1.0), strict=True))  # of a coefficient, times a deviation
TREND_POWERS = 4  # of time, that a smooth trend has: it moves with the temperature
PARTS_OF_A_TREND = 20.0  # of a recording, as long as the longest averaging time that it leaves as it is
TREND_RATIO = 2.0  # between the intervals with and without the trend
DRIFT_TERMS = ("bias_instability", "rate_random_walk")


def fit_from(curve: AllanDeviation, tau: float, quantum: float, last: float = np.inf) -> NoiseFit:
    """Return the terms of a curve from averaging times ``tau`` to ``last`` [s]; ``quantum``: `fit_noise`."""
    rows = (curve.tau >= tau) & (curve.tau <= last)
    if not rows.any():
        return NoiseFit(dict.fromkeys(TERMS, UNDETERMINED), 0.0)
    names = ("tau", "deviation", "low", "high", "edf")
    return fit_noise(AllanDeviation(*(getattr(curve, name)[rows] for name in names)), quantum)


def without_rounding(fit: NoiseFit, variance: float, period: float) -> NoiseFit:
    """Return the fit less the white noise that rounding adds, ``variance`` a sample, ``period`` [s] apart."""
    walk = fit.terms["random_walk"]
    added = variance * period
    if walk.value is None or not added:
        return fit
    low, value, high = (np.sqrt(max(each**2 - added, 0.0)) for each in (walk.low, walk.value, walk.high))
    known = NoiseTerm(float(value), float(low), float(high)) if low > 0 else NoiseTerm(None, 0.0, float(high))
    return replace(fit, terms={**fit.terms, "random_walk": known})


def of_levels(white: NoiseOfLevels, step: float, period: float) -> NoiseFit:
    """Return the random walk of white noise that the levels of an output determine, ``step`` in its unit apart."""
    unit = step * float(np.sqrt(period))
    value = None if white.value is None else white.value * unit
    walk = NoiseTerm(value, white.low * unit, white.high * unit if np.isfinite(white.high) else np.inf)
    return NoiseFit({**dict.fromkeys(TERMS, UNDETERMINED), "random_walk": walk}, 0.0)


def undetermined(fit: NoiseFit, conditions: Sequence[Condition]) -> NoiseFit:
    """Return the fit without the terms that a condition leaves undetermined."""
    lost = {name for each in conditions for name in each.undetermined}
    terms = {name: UNDETERMINED if name in lost else term for name, term in fit.terms.items()}
    return NoiseFit(terms, 0.0 if lost == set(ALL) else fit.log_p)


def wider(fit: NoiseFit, low: Mapping[str, float], high: Mapping[str, float]) -> NoiseFit:
    """Return the fit with its limits times factors by term."""
    each = fit.terms.items()
    return replace(fit, terms={k: NoiseTerm(t.value, t.low * low[k], t.high * high[k]) for k, t in each})


def stamps_in_turn(t: FloatArray) -> Condition | None:
    """Return that rows at ``t`` (n,) [s] come at the times of two or three devices that slip past each other.

    Each device's own steps are alike, those between devices are not, and differ from a burst's.
    """
    steps = np.diff(t)
    if len(steps) < MIN_STEPS:
        return None
    steps = np.round(steps / steps.mean(), 6)
    ticks = np.unique(steps)
    tick = float(np.diff(ticks).min()) if len(ticks) > 1 else 0.0
    if tick and np.abs(ticks / tick - np.round(ticks / tick)).max() > 0.05:
        tick = 0.0  # stamps are finer than that
    spread = float(steps.std())
    if spread < max(MIN_STEP_SPREAD, 1.5 * tick):
        return None
    for p in (2, 3):
        own = np.convolve(steps, np.ones(p), mode="valid")
        is_burst = np.mean((steps < 0.05) | (steps > 0.95 * p)) > 0.9
        if np.median(np.abs(own - np.median(own))) < OWN_STEP_SPREAD * spread and not is_burst:
            text = f"Time stamps come in turn, as of {p} devices in one file. Separate the rows by device."
            return Condition("interleaved", text, ALL, {"devices": float(p)}, is_of_recording=True)
    return None


def changing_interval(t: FloatArray) -> tuple[Condition, float, float] | None:
    """Return that the interval of rows at ``t`` (n,) [s] changes, and its extremes over its mean; None if not."""
    steps = np.diff(t)
    if len(steps) < 8 * INTERVAL_BLOCKS:
        return None
    blocks = np.array_split(steps, INTERVAL_BLOCKS)
    means = np.array([block.mean() for block in blocks])
    scatter = np.median([block.std() for block in blocks]) / np.sqrt(len(blocks[0]))
    mean = float(steps.mean())
    if np.ptp(means) < MIN_INTERVAL_CHANGE * mean + INTERVAL_SIGMAS * scatter:
        return None
    low, high = float(means.min()), float(means.max())
    lost = ALL if high > MAX_INTERVAL_CHANGE * low else ()
    text = (
        f"The interval from row to row changes from {1e3 * means[0]:.4g} to {1e3 * means[-1]:.4g} ms along the "
        f"recording ({1e3 * low:.4g} to {1e3 * high:.4g} ms): averaging times and frequencies are approximate."
    )
    values = {"first_s": float(means[0]), "last_s": float(means[-1]), "low_s": low, "high_s": high}
    return Condition("changing_interval", text, lost, values), low / mean, high / mean


def without_trend(
    rate: FloatArray, period: float, fit: NoiseFit, tau: float
) -> tuple[NoiseFit, tuple[Condition, ...]]:
    """Return the fit with bounds for what is a smooth trend in ``rate`` (n,), ``period`` [s] apart, and no noise.

    ``tau`` [s] is the least averaging time. Without a polynomial a trend goes, a random walk hardly.
    """
    seen = [name for name in DRIFT_TERMS if fit.terms[name].value is not None]
    if not seen or not _is_large(fit, seen, len(rate) * period / 10):
        return fit, ()
    x = np.linspace(-1, 1, len(rate))
    left = rate - np.polynomial.legendre.legval(x, np.polynomial.legendre.legfit(x, rate, TREND_POWERS))
    last = len(rate) * period / PARTS_OF_A_TREND  # the polynomial takes what is slower, of any process
    bare = fit_from(overlapping_deviation(left, period), tau, 0.0, last)
    gone = [name for name in seen if bare.terms[name].high * TREND_RATIO < fit.terms[name].low]
    if not gone:
        return fit, ()
    text = (
        "A smooth trend, as of the temperature, explains most of the drift: it is no random process, and what "
        "looks like one is only a bound."
    )
    bounds = {name: NoiseTerm(None, 0.0, fit.terms[name].high) for name in gone}
    return replace(fit, terms={**fit.terms, **bounds}), (Condition("smooth_trend", text),)


def _is_large(fit: NoiseFit, names: Sequence[str], tau: float) -> bool:
    """Say whether terms are twice the random walk at ``tau`` [s]: of less an interval says little."""
    shapes = noise_shapes(np.array([tau]))
    sizes = {name: float(shapes[name][0]) * (fit.terms[name].value or 0.0) for name in TERMS}
    return any(sizes[name] > 2 * sizes["random_walk"] for name in names)
