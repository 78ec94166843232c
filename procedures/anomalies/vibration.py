"""How large a disturbance was: the sine that fits it best, in the stretch where it fits best.

In a signal e that holds ``Re(a exp(2 pi i f t))`` and noise of variance s^2 the sums ``Z = sum e exp(-2 pi i f
t)`` over N samples gather ``|Z|^2 / N = N |a|^2 / 4``; frequency and stretch are where that, over s^2 and summed
over the axes, is largest; at each frequency s^2 is what the quiet part of the step holds there, since counts at a
low rate are a sawtooth with lines of its own. Of counts with little noise e is the running count about a parabola,
where a sine of A g stands as ``k A / (2 pi f)``, measured by `procedures.anomalies.vibration`; of noisy
channels it is the samples. How a sample averages the sine within itself is open: the middle between the mean over
it and its value at mid-sample is taken, and half their difference is part of the sigma. What is no sine is given
by the amplitude of a sine of its rms, and no frequency.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from procedures.arrays import FloatArray

MAX_NODES = 600  # of a stretch, about its middle
STRIP_SLACK = 0.02  # counts, for noise and what the frequency is off
STD_PER_HALF_EXTENT = 0.5  # of a half extent: sigma; of a uniform distribution it is 1 / sqrt(3)
SHAPE_COLUMNS = 3  # level, slope, bend
TRIED_OFFSETS = (0.0, -0.17, 0.17, -0.33, 0.33, -0.5, 0.5)  # of a period per stretch, the likeliest first
MAX_SINE_STRIP = 1.3  # counts: a narrowest strip above this is no sine in counts


@dataclass(frozen=True, slots=True)
class SineInCounts:
    """Amplitude [counts] with 1 sigma of a sine, and the strip it needs: 1 or less if all counts allow it."""

    amplitude: float
    std: float
    strip: float


def best_hertz(running: FloatArray, hertz: float, period: float) -> float:
    """Return the frequency [Hz] at which ``running`` counts (n, 3) need the narrowest strips.

    It is looked for within half a period per stretch of ``hertz``.
    """
    _, level = _middle(running)
    n = len(level)
    near = hertz + np.array(TRIED_OFFSETS) / (n * period)
    needed = [sum(max(narrowest(level[:, q], _design(n, f, period)), 1.0) for q in range(3)) for f in near]
    return float(near[int(np.argmin(needed))])


def strip_with_sine(running: FloatArray, hertz: float, period: float, first: int, end: int) -> float:
    """Return the strips, summed over axes, that ``running`` counts (n, 3) need in addition to a sine.

    It acts from sample ``first`` to ``end``. Before and after it, and while it acts, the count has levels of its
    own.
    """
    begin, level = _middle(running)
    at = np.arange(begin, begin + len(level))
    acts, after = ((at >= first) & (at < end))[:, None], (at >= end)[:, None]
    columns = _design(len(level), hertz, period)
    design: FloatArray = np.hstack(
        (columns[:, :SHAPE_COLUMNS], 1.0 * acts, 1.0 * after, acts * columns[:, SHAPE_COLUMNS:])
    )
    return float(sum(max(narrowest(level[:, axis], design), 1.0) for axis in range(3)))


def sine_between(count: FloatArray, hertz: float, period: float) -> SineInCounts:
    """Bound a sine of ``hertz`` in a running count (n,)."""
    _, count = _middle(count)
    design = _design(len(count), hertz, period)
    strip = narrowest(count, design)
    if not np.isfinite(strip):
        return SineInCounts(0.0, np.inf, np.inf)
    allowed = max(strip, 1.0) + STRIP_SLACK
    bounds = np.array([[_extreme(count, design, allowed, k, sign) for sign in (1, -1)] for k in (0, 1)])
    middle, half = bounds.mean(axis=1), np.ptp(bounds, axis=1) / 2
    std = float(np.hypot(np.hypot(*half) / np.sqrt(2) * STD_PER_HALF_EXTENT, max(strip - 1, 0.0)))
    size = float(np.hypot(*middle))
    return SineInCounts(float(np.sqrt(max(size**2 - std**2, 0.0))), std, strip)


def _middle(running: FloatArray) -> tuple[int, FloatArray]:
    """Return where the middle `MAX_NODES` of a stretch begin, and these next to the first of them."""
    begin = max((len(running) - MAX_NODES) // 2, 0)
    return begin, running[begin : begin + MAX_NODES] - running[begin]


def narrowest(count: FloatArray, design: FloatArray) -> float:
    """Return the narrowest strip [counts] that columns ``design`` (n, m) leave of ``count`` (n,)."""
    m = design.shape[1]
    A = np.vstack(
        (np.hstack((-design, np.zeros((len(count), 1)))), np.hstack((design, -np.ones((len(count), 1)))))
    )
    found = linprog(
        np.r_[np.zeros(m), 1.0],
        A_ub=A,
        b_ub=np.r_[-count, count],
        bounds=[(None, None)] * m + [(0, None)],
        method="highs",
    )
    return np.inf if found.fun is None else float(found.fun)


def _extreme(count: FloatArray, design: FloatArray, strip: float, k: int, sign: int) -> float:
    """Return the least (``sign`` 1) or largest (-1) coefficient of cosine (0) or sine (1)."""
    aim = np.zeros(design.shape[1])
    aim[SHAPE_COLUMNS + k] = sign
    A, b = np.vstack((-design, design)), np.r_[-count, count + strip]
    found = linprog(aim, A_ub=A, b_ub=b, bounds=[(None, None)] * len(aim), method="highs")
    return float(-sign * len(count)) if found.fun is None else sign * float(found.fun)


def _design(n: int, hertz: float, period: float) -> FloatArray:
    x, phase = np.linspace(-1, 1, n), 2 * np.pi * hertz * period * np.arange(n)
    return np.stack((np.ones(n), x, x**2, np.cos(phase), np.sin(phase)), axis=1)


ComplexArray = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]

TINY = 1e-300  # of a channel that is not there
FFT_PADDING = 4  # times as many frequencies as samples
LINES_TRIED, MAX_LINES = 3, 10  # tried of all axes together and of each; in all
MAX_EXTRA_STRIP = 0.15  # counts of strip, summed over the axes, more than the least: what edges a little off cost
EQUAL_STRIP = 0.03  # within which another frequency is allowed as well as the best
MAX_LEFT_VARIANCE = 2.0  # times its own variance a sine is allowed to leave next to it
MIN_PERIODS = 2.0  # whole periods a stretch must hold
MIN_STRETCH_PART = 6  # of the part looked at, the least that the stretch is
EDGES_TRIED = 80  # tried for either end of the stretch


@dataclass(frozen=True, slots=True)
class Vibration:
    """A sine from sample ``first`` to ``end``: ``amplitude`` (3,) and 1 sigma (3,) in input units.

    ``hertz`` is 0 of what is no sine.
    """

    hertz: float
    first: int
    end: int
    amplitude: FloatArray
    std: FloatArray


def measure_vibration(
    samples: FloatArray, k: FloatArray, period: float, stretch: slice, cumulative: bool
) -> Vibration:
    """Measure the disturbance of a step's ``samples`` (n, 3) that was seen in ``stretch``; the rest is its noise.

    ``k`` (3,) is a sample per input unit. ``cumulative``: judge the running sum.
    """
    signal = _detrended(np.cumsum(samples, axis=0) if cumulative else samples)
    n, length = len(signal), stretch.stop - stretch.start
    quiet = np.ones(n, dtype=bool)
    quiet[stretch] = False
    noise = np.maximum((signal[quiet] if quiet.sum() > 16 else signal).std(axis=0), 1e-12)
    wide = slice(max(stretch.start - length // 2, 0), min(stretch.stop + length // 2, n))
    stretches = {
        hertz: _edges(signal[wide] * _turning(wide, hertz, period) / noise, wide.start)
        for hertz in _frequencies(signal, stretch, noise, period)[: MAX_LINES if cumulative else 1]
    }
    if cumulative:
        hertz, a, scatter = _counted(samples, period, stretch, stretches)
        first, end = stretches[hertz]
        is_sine = bool(np.all(np.isfinite(scatter)))
    else:
        hertz, (first, end) = next(iter(stretches.items()))
        a, scatter = _sine(signal * _turning(slice(0, n), hertz, period), first, end, noise)
        is_sine = bool(2 * _excess(samples, first, end)[0].max() < MAX_LEFT_VARIANCE * (a**2).max())
    if not is_sine:
        a, scatter = _rms(samples, first, end)
        return Vibration(0.0, first, end, a / np.abs(k), scatter / np.abs(k))
    phase = np.pi * hertz * period
    by_mean, by_middle = (1.0, phase / np.sin(phase)) if cumulative else (np.sinc(hertz * period), 1.0)
    gain = np.abs(k) * (by_mean + by_middle) / 2 / (2 * phase if cumulative else 1.0)
    std = np.hypot(scatter, a * abs(by_middle - by_mean) / (by_middle + by_mean)) / gain
    return Vibration(hertz, first, end, a / gain, std)


def _counted(
    samples: FloatArray, period: float, stretch: slice, stretches: Mapping[float, tuple[int, int]]
) -> tuple[float, FloatArray, FloatArray]:
    """Return the frequency that stands out first of those that counts allow, amplitude (3,) [counts] and 1 sigma.

    Infinite is the sigma of what counts do not allow; else it spans what other frequencies, allowed best, would
    make of it: as accelerations, each as counts at the one chosen.
    """
    running = np.cumsum(samples[stretch], axis=0)
    needed = {
        hertz: strip_with_sine(running, hertz, period, first - stretch.start, end - stretch.start)
        for hertz, (first, end) in stretches.items()
    }
    least = min(needed.values())
    chosen = next(hertz for hertz, strip in needed.items() if strip <= least + MAX_EXTRA_STRIP)
    a, scatter = _between(samples, period, chosen, *stretches[chosen])
    for hertz, strip in needed.items():
        if strip <= least + EQUAL_STRIP and hertz != chosen:
            other, _ = _between(samples, period, hertz, *stretches[hertz])
            scatter = np.maximum(scatter, np.abs(other * hertz / chosen - a))
    return chosen, a, scatter


def _between(
    samples: FloatArray, period: float, hertz: float, first: int, end: int
) -> tuple[FloatArray, FloatArray]:
    """Return the amplitude (3,) [counts] of a sine near ``hertz`` and 1 sigma, infinite of what is not allowed."""
    inner = slice(first + (end - first) // 10, end - (end - first) // 10)
    running = np.cumsum(samples[inner], axis=0)
    near = best_hertz(running, hertz, period)
    found = [sine_between(running[:, axis], near, period) for axis in range(3)]
    a, std = np.array([each.amplitude for each in found]), np.array([each.std for each in found])
    return a, std if max(each.strip for each in found) < MAX_SINE_STRIP else np.full(3, np.inf)


def _turning(samples: slice, hertz: float, period: float) -> ComplexArray:
    return np.exp(-2j * np.pi * hertz * period * np.arange(samples.start, samples.stop))[:, None]


def _sine(turned: ComplexArray, first: int, end: int, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the amplitude (3,) of a line, less what noise adds to it, and 1 sigma."""
    a, scatter = 2 * np.abs(np.mean(turned[first:end], axis=0)), _scatter(turned, first, end, noise)
    return np.sqrt(np.maximum(a**2 - scatter**2, 0.0)), scatter


def _excess(samples: FloatArray, first: int, end: int) -> tuple[FloatArray, FloatArray]:
    """Return by how much the samples' variance (3,) exceeds that of quiet stretches as long, and 1 sigma."""
    begins, variance = _quiet_windows(len(samples), first, end), samples[first:end].var(axis=0)
    if not begins:
        return variance, variance
    quiet = np.array([samples[b : b + end - first].var(axis=0) for b in begins])
    excess = np.maximum(variance - np.median(quiet, axis=0), 0.0)
    return excess, np.hypot(np.std(quiet, axis=0), variance * np.sqrt(2 / (end - first)))


def _rms(samples: FloatArray, first: int, end: int) -> tuple[FloatArray, FloatArray]:
    """Return the amplitude (3,) of a sine with as much variance as a disturbance that is none, and 1 sigma."""
    excess, std = _excess(samples, first, end)
    amplitude = np.sqrt(2 * excess)
    return amplitude, std / np.maximum(np.maximum(amplitude, np.sqrt(std)), TINY)


def _detrended(signal: FloatArray) -> FloatArray:
    x = np.linspace(-1, 1, len(signal))
    design = np.stack((np.ones_like(x), x, x**2), axis=1)
    return signal - design @ np.linalg.lstsq(design, signal, rcond=None)[0]


def _frequencies(signal: FloatArray, stretch: slice, noise: FloatArray, period: float) -> list[float]:
    """Return the frequencies [Hz] whose lines stand out from the quiet part's spectrum, of all axes first."""
    length = stretch.stop - stretch.start
    hertz = np.fft.rfftfreq(FFT_PADDING * length, period)
    quiet = np.tile(noise**2 * length, (len(hertz), 1))
    begins = _quiet_windows(len(signal), stretch.start, stretch.stop)
    if begins:
        quiet = np.maximum(quiet, np.mean([_power(signal[b : b + length]) for b in begins], axis=0))
    each = _power(signal[stretch]) / quiet
    usable = (hertz * length * period >= MIN_PERIODS) & (hertz * period < 0.49)
    peaks = list[int]()
    for stands_out, many in ((each.sum(axis=1), LINES_TRIED), *((axis, LINES_TRIED) for axis in each.T)):
        left = np.where(usable, stands_out, 0.0)
        for _ in range(many):
            at = int(np.argmax(left))
            left[max(at - FFT_PADDING, 0) : at + FFT_PADDING + 1] = 0.0
            if not any(abs(at - other) < FFT_PADDING for other in peaks):
                peaks.append(at)
    return [float(hertz[at]) for at in peaks]


def _power(signal: FloatArray) -> FloatArray:
    return np.abs(np.fft.rfft(_detrended(signal), FFT_PADDING * len(signal), axis=0)) ** 2


def _quiet_windows(n: int, first: int, end: int) -> list[int]:
    """Return where half-overlapping windows as long as a stretch begin that lie outside it."""
    length = end - first
    return [b for b in range(0, n - length + 1, max(length // 2, 1)) if b + length <= first or b >= end]


def _edges(turned: ComplexArray, begin: int) -> tuple[int, int]:
    """Return first and end, from ``begin`` on, of what gathers most: argmax of |Z|^2 / N over pairs of edges."""
    n = len(turned)
    at = np.unique(np.linspace(0, n, min(EDGES_TRIED, n) + 1).round().astype(int))
    sums = np.vstack((np.zeros((1, turned.shape[1])), np.cumsum(turned, axis=0)))[at]
    i, j = np.triu_indices(len(at), max(len(at) // MIN_STRETCH_PART, 1))
    gathered = np.sum(np.abs(sums[j] - sums[i]) ** 2, axis=1) / (at[j] - at[i])
    best = int(np.argmax(gathered))
    return begin + int(at[i[best]]), begin + int(at[j[best]])


def _scatter(turned: ComplexArray, first: int, end: int, noise: FloatArray) -> FloatArray:
    """Return 1 sigma (3,) of an amplitude: what stretches as long hold of the same frequency where it is quiet.

    At the least what white noise leaves: counts at a low rate are a sawtooth, with lines of its own.
    """
    length = end - first
    white: FloatArray = noise * np.sqrt(2 / length)
    begins = _quiet_windows(len(turned), first, end)
    if not begins:
        return 2 * white
    each = np.array([2 * np.abs(turned[b : b + length].mean(axis=0)) for b in begins])
    found: FloatArray = np.maximum(white, np.sqrt(np.mean(each**2, axis=0) / 2))
    return found
