"""The noise terms that are left of a recording with conditions: bounds, wider intervals, or not determined."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.statistics.allan_deviation import AllanDeviation, overlapping_deviation
from procedures.statistics.conditions.condition import ALL, Condition
from procedures.statistics.conditions.levels import NoiseOfLevels
from procedures.statistics.noise_terms import TERMS, NoiseFit, NoiseTerm, fit_noise, noise_shapes

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
    """Return the random walk of white noise that the levels of an output tell, ``step`` in its unit apart."""
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
    terms = {
        name: NoiseTerm(term.value, term.low * low[name], term.high * high[name])
        for name, term in fit.terms.items()
    }
    return replace(fit, terms=terms)


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

    ``tau`` [s] is the least averaging time. Without a polynomial a random walk stays as large as its interval
    says, but for its slowest part; a trend goes.
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
