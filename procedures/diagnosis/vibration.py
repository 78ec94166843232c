"""How large a disturbance was: the sine that fits it best, in the stretch where it fits best.

In a signal e that holds ``Re(a exp(2 pi i f t))`` and noise of variance s^2 the sums ``Z = sum e exp(-2 pi i f
t)`` over N samples gather ``|Z|^2 / N = N |a|^2 / 4``; frequency and stretch are where that, over s^2 and summed
over the axes, is largest; at each frequency s^2 is what the quiet part of the step holds there, since counts at a
low rate are a sawtooth with lines of its own. Of counts with little noise e is the running count about a parabola,
where a sine of A g stands as ``k A / (2 pi f)``, measured by `procedures.diagnosis.between_counts`; of noisy
channels it is the samples. How a sample averages the sine within itself is open: the middle between the mean over
it and its value at mid-sample is taken, and half their difference is part of the sigma.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.between_counts import NOT_ALLOWED, best_hertz, sine_between

PAD = 4  # times as many frequencies as samples
LOWEST = 2.0  # whole periods a stretch must hold
EDGES = 80  # tried for either end of the stretch


@dataclass(frozen=True, slots=True)
class Vibration:
    """A sine at ``hertz`` from sample ``first`` to ``end``; ``amplitude`` (3,) and 1 sigma (3,) in input units."""

    hertz: float
    first: int
    end: int
    amplitude: FloatArray
    std: FloatArray


def measure(samples: FloatArray, k: FloatArray, period: float, stretch: slice, cumulative: bool) -> Vibration:
    """Measure the disturbance of a step's ``samples`` (n, 3) that was seen in ``stretch``; the rest is its noise.

    ``k`` (3,) is a sample per input unit. ``cumulative``: judge the running sum.
    """
    signal = _detrended(np.cumsum(samples, axis=0) if cumulative else samples)
    n, length = len(signal), stretch.stop - stretch.start
    quiet = np.ones(n, dtype=bool)
    quiet[stretch] = False
    rest = signal[quiet] if quiet.sum() > 16 else signal
    noise = np.maximum(rest.std(axis=0), 1e-12)
    frequency = _frequency(signal, stretch, noise, period)
    wide = slice(max(stretch.start - length // 2, 0), min(stretch.stop + length // 2, n))
    turning = np.exp(-2j * np.pi * frequency * period * np.arange(n))[:, None]
    first, end = _edges(signal[wide] * turning[wide] / noise)
    first, end = first + wide.start, end + wide.start
    turned = signal * turning
    a, scatter = 2 * np.abs(np.mean(turned[first:end], axis=0)), _scatter(turned, first, end, noise)
    a = np.sqrt(np.maximum(a**2 - scatter**2, 0.0))
    if cumulative:
        inner = slice(first + (end - first) // 10, end - (end - first) // 10)
        running = np.cumsum(samples[inner], axis=0)
        frequency = best_hertz(running, frequency, period)
        found = [sine_between(running[:, axis], frequency, period) for axis in range(3)]
        if max(each.strip for each in found) < NOT_ALLOWED:
            a, scatter = np.array([each.amplitude for each in found]), np.array([each.std for each in found])
    phase = np.pi * frequency * period
    by_mean, by_middle = (1.0, phase / np.sin(phase)) if cumulative else (np.sinc(frequency * period), 1.0)
    gain = np.abs(k) * (by_mean + by_middle) / 2 / (2 * phase if cumulative else 1.0)
    std = np.hypot(scatter, a * abs(by_middle - by_mean) / (by_middle + by_mean)) / gain
    return Vibration(frequency, first, end, a / gain, std)


def _detrended(signal: FloatArray) -> FloatArray:
    x = np.linspace(-1, 1, len(signal))
    design = np.stack((np.ones_like(x), x, x**2), axis=1)
    left: FloatArray = signal - design @ np.linalg.lstsq(design, signal, rcond=None)[0]
    return left


def _frequency(signal: FloatArray, stretch: slice, noise: FloatArray, period: float) -> float:
    """Return the frequency [Hz] whose line stands out most from the quiet part's spectrum, three axes together."""
    length = stretch.stop - stretch.start
    hertz = np.fft.rfftfreq(PAD * length, period)
    quiet = np.tile(noise**2 * length, (len(hertz), 1))
    begins = _quiet_windows(len(signal), stretch.start, stretch.stop)
    if begins:
        quiet = np.maximum(quiet, np.mean([_power(signal[b : b + length]) for b in begins], axis=0))
    stands_out = np.sum(_power(signal[stretch]) / quiet, axis=1)
    usable = (hertz * length * period >= LOWEST) & (hertz * period < 0.49)
    return float(hertz[np.argmax(np.where(usable, stands_out, 0.0))])


def _power(signal: FloatArray) -> FloatArray:
    power: FloatArray = np.abs(np.fft.rfft(_detrended(signal), PAD * len(signal), axis=0)) ** 2
    return power


def _quiet_windows(n: int, first: int, end: int) -> list[int]:
    """Return where half-overlapping windows as long as a stretch begin that lie outside it."""
    length = end - first
    return [b for b in range(0, n - length + 1, max(length // 2, 1)) if b + length <= first or b >= end]


def _edges(turned: FloatArray) -> tuple[int, int]:
    """Return first and end of the stretch that gathers most: argmax of |Z|^2 / N over pairs of edges."""
    n = len(turned)
    at = np.unique(np.linspace(0, n, min(EDGES, n) + 1).round().astype(int))
    sums = np.vstack((np.zeros((1, turned.shape[1])), np.cumsum(turned, axis=0)))[at]
    i, j = np.triu_indices(len(at), 1)
    gathered = np.sum(np.abs(sums[j] - sums[i]) ** 2, axis=1) / (at[j] - at[i])
    best = int(np.argmax(gathered))
    return int(at[i[best]]), int(at[j[best]])


def _scatter(turned: FloatArray, first: int, end: int, noise: FloatArray) -> FloatArray:
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
