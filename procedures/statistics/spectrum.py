"""Power spectral density of a record, and the lines that stand out of it.

The density is Welch's, with Hann's window and halves overlapping, one-sided: its integral over the frequencies is
the variance. Lines are looked for in the spectrum of the whole record, which resolves 1 / T: in noise of whatever
colour the power over that of the neighbours is exponentially distributed, so that the largest of m exceeds x by
chance with probability ``m exp(-x)``, or a little more for what is not known of the neighbours. What is slower
than `MIN_PERIODS` periods in the record is drift and no line.

Sums over a sine at evenly spaced samples take no sine of every sample: sample k is a multiple of m and a rest, so
twice the root of n are exponentials, the others products of two.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from procedures.arrays import FloatArray

MIN_SAMPLES = 64
WELCH_PARTS = 16  # as many segments as fit, halves overlapping; fewer of short records
MAX_SEGMENT = 2**15
MIN_PERIODS = 16.0
MAX_LOG_P = np.log(1e-4)  # of a line, all frequencies counted
MAX_LINES = 20
NEIGHBOURS, WIDTH = 129, 0.1  # frequencies whose median is the background, at least; or this part of the frequency
BACKGROUND_DOF = 2 * NEIGHBOURS / (1.5 * 2.08)  # of a median of exponentials, 1.5 of them hanging together
WINDOW_BINS = 3  # on either side, that Hann's window gives to one line
SLOWED = 2**12  # parts of a record whose sums determine a line's frequency: off by 5e-4 sigma a bin away
MEDIAN_OF_EXPONENTIAL = np.log(2.0)


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """``density`` (m,) [R^2/Hz], one-sided, at the frequencies ``hertz`` (m,); ``dof`` behind each value."""

    hertz: FloatArray
    density: FloatArray
    dof: float


@dataclass(frozen=True, slots=True)
class Line:
    """A sine: frequency [Hz] and amplitude with 1 sigma each, and its ``share`` of the record's variance.

    ``log_p`` is that of noise which looks like it, all frequencies counted.
    """

    hertz: float
    hertz_std: float
    amplitude: float
    amplitude_std: float
    log_p: float
    share: float


def spectrum_of(rate: FloatArray, period: float) -> Spectrum:
    """Return the density of a gap-free ``rate`` (n,) in any unit, samples ``period`` [s] apart."""
    segment = int(min(2 ** np.floor(np.log2(max(2 * len(rate) / (WELCH_PARTS + 1), 16))), MAX_SEGMENT, len(rate)))
    hertz, density = welch(rate, period, segment)
    parts = max(2 * len(rate) // segment - 1, 1)
    # Welch 1967: neighbouring halves under Hann's window share 1/36 of their variance
    return Spectrum(hertz[1:-1], density[1:-1], 2 * parts / (1 + 2 * (parts - 1) / parts / 36))


def welch(rate: FloatArray, period: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """Return frequencies [Hz] and density of ``rate`` (n,) in parts of ``segment`` samples, halves overlapping.

    What ``scipy.signal.welch`` gives, to the last bit of version 1.17; a quarter of a second to import.
    """
    window = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, segment + 1)[:-1])
    window *= 1 / np.sqrt(np.cumsum(window**2)[-1] / (1 / (1 / period)))
    parts = sliding_window_view(rate, segment)[:: segment - segment // 2]
    found = np.fft.rfft(without_straight_line(parts) * window)
    power = np.ascontiguousarray((found.real**2 + found.imag**2).T)
    power[1 : None if segment % 2 else -1] *= 2
    hertz: FloatArray = np.fft.rfftfreq(segment, 1 / (1 / period)).astype(np.float64)
    return hertz, power.mean(axis=-1)


def lines_of(rate: FloatArray, period: float) -> list[Line]:
    """Return the lines of a gap-free ``rate`` (n,) in any unit, the strongest first."""
    n = len(rate)
    if n < MIN_SAMPLES or not np.ptp(rate) > 0:
        return []
    level = without_straight_line(rate)
    window = hann(n)
    weighed, mean_square = level * window / window.sum(), float(np.mean(level**2))
    power = np.abs(np.fft.rfft(level * window)) ** 2 / float(window @ window)  # mean: the variance, of white noise
    begin = int(MIN_PERIODS)
    background = background_of(power, begin)
    ratio = power / background
    ratio[:begin], ratio[-WINDOW_BINS:] = 0.0, 0.0
    found = list[Line]()
    while len(found) < MAX_LINES:
        at = int(np.argmax(ratio))
        log_p = float(np.log(len(ratio) - begin) - BACKGROUND_DOF / 2 * np.log1p(2 * ratio[at] / BACKGROUND_DOF))
        if not log_p < MAX_LOG_P:
            break
        found.append(_line(weighed, mean_square, at, period, float(background[at]), log_p))
        ratio[max(at - WINDOW_BINS, 0) : at + WINDOW_BINS + 1] = 0.0
    return sorted(found, key=lambda line: -line.amplitude)


def without_lines(rate: FloatArray, period: float, lines: Sequence[Line]) -> FloatArray:
    """Return ``rate`` (n,) in its unit less the sines that fit it best at the lines' frequencies."""
    left: FloatArray = rate - rate.mean()
    for line in lines:
        turns = line.hertz * period
        left -= sine(len(left), turns, 2 * sine_sum(left, turns) / len(left))
    return left


def sine_at(rate: FloatArray, turns: float) -> complex:
    """Return a of the sine real(a exp(2 pi i turns k)) in ``rate`` (n,), its unit, ``turns`` [turns per sample].

    Under Hann's window, so that a drift is not taken for it.
    """
    window = hann(len(rate))
    return 2 * sine_sum(without_straight_line(rate) * window / window.sum(), turns)


def has_line(values: FloatArray, period: float, hertz: float) -> bool:
    """Say whether ``values`` (n,) in any unit, read now and then and nan between, have a line at a frequency."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < MIN_SAMPLES:
        return False
    filled = np.interp(np.arange(len(values)), known, values[known])
    return any(abs(line.hertz - hertz) * len(values) * period < 1 for line in lines_of(filled, period))


def hann(n: int) -> FloatArray:
    """Return Hann's window (n,), without unit, of samples in the middles of their intervals."""
    return 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n)


def without_straight_line(rate: FloatArray) -> FloatArray:
    """Return records ``rate`` (..., n), in their unit, less their mean and slope."""
    t = (np.arange(rate.shape[-1]) + 0.5) / rate.shape[-1] - 0.5
    level: FloatArray = rate - rate.mean(axis=-1, keepdims=True)
    level -= 12 * np.mean(level * t, axis=-1, keepdims=True) * t
    return level


def background_of(power: FloatArray, begin: int) -> FloatArray:
    """Return what noise has at every frequency of periodograms ``power`` (..., m), their unit, from ``begin`` on.

    It is medians of neighbours, in between straight in the logarithms.
    """
    edges = [begin]
    while edges[-1] < power.shape[-1]:
        edges.append(edges[-1] + max(NEIGHBOURS, round(WIDTH * edges[-1])))
    edges = [*edges[:-2], power.shape[-1]] if len(edges) > 2 else [begin, power.shape[-1]]
    near = [np.median(power[..., i:j], axis=-1) for i, j in pairwise(edges)]
    least = np.finfo(float).tiny + 1e-12 * power.mean(axis=-1, keepdims=True)
    y = np.log(np.maximum(np.stack(near, axis=-1), least) / MEDIAN_OF_EXPONENTIAL)
    x = np.log([(i + j) / 2 for i, j in pairwise(edges)])
    if len(x) == 1:
        return np.broadcast_to(np.exp(y), power.shape)
    at = np.minimum(np.log(np.maximum(np.arange(power.shape[-1]), 1.0)), x[-1])
    k = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    background: FloatArray = np.exp(y[..., k] + np.diff(y)[..., k] * ((at - x[k]) / np.diff(x)[k]))
    return background


def _line(
    weighed: FloatArray, mean_square: float, at: int, period: float, background: float, log_p: float
) -> Line:
    """Return the sine near bin ``at``: the frequency where a fit of it takes most, half a bin either way."""
    n = len(weighed)
    middles, sums = slowed(weighed, at / n, SLOWED)

    def heights(bins: FloatArray) -> FloatArray:
        found: FloatArray = np.abs(np.exp(-2j * np.pi / n * np.outer(bins - at, middles)) @ sums)
        return found

    near = at + np.array([-0.5, 0.0, 0.5])
    for _ in range(3):
        height = heights(near)
        bend = height[0] - 2 * height[1] + height[2]
        shift = 0.5 * (height[0] - height[2]) / bend if bend < 0 else 0.0
        step = near[1] - near[0]
        near = near[1] + np.clip(shift, -1, 1) * step + np.array([-0.25, 0.0, 0.25]) * step
    amplitude = 2 * float(heights(near[1:2])[0])
    std = float(np.sqrt(2 * background / n * 1.5))  # 1.5: the window's equivalent bandwidth, in bins
    hertz_std = np.sqrt(6) * std / (np.pi * amplitude * n * period) * 1.4  # Rife and Boorstyn 1974, windowed
    share = amplitude**2 / 2 / mean_square
    return Line(float(near[1]) / (n * period), float(hertz_std), amplitude, std, log_p, min(share, 1.0))


Complex = npt.NDArray[np.complex128]


def sine(n: int, turns: float, amplitude: complex) -> FloatArray:
    """Return the real part (n,) of amplitude exp(2 pi i turns k), in its unit, ``turns`` [turns per sample]."""
    coarse, fine = _factors(n, turns)
    coarse = amplitude * coarse
    product = np.stack((coarse.real, -coarse.imag), axis=1) @ np.stack((fine.real, fine.imag))
    return product.ravel()[:n]


def sine_sum(values: FloatArray, turns: float) -> complex:
    """Return the sum over k of values (n,) times exp(-2 pi i turns k), in their unit."""
    n = len(values)
    coarse, fine = _factors(n, -turns)
    whole = n // len(fine)
    parts = values[: whole * len(fine)].reshape(whole, -1) @ np.stack((fine.real, fine.imag), axis=1)
    rest = values[whole * len(fine) :]
    total = coarse[:whole] @ (parts[:, 0] + 1j * parts[:, 1])
    return complex(total + (coarse[whole] * (rest @ fine[: len(rest)]) if len(rest) else 0.0))


def slowed(values: FloatArray, turns: float, least: int) -> tuple[FloatArray, Complex]:
    """Return the middles of ``least`` or more parts, and sums over them of values (n,) times exp(-2 pi i turns k).

    The middles [samples] and sums (m,) determine the frequencies near as ``sums @ exp(-2 pi i d middles)``, d
    turns per sample away: the samples of a part turn alike.
    """
    n = len(values)
    size = max(n // least, 1)
    edges = np.arange(0, n, size)
    real, imaginary = (np.add.reduceat(values * sine(n, turns, phase), edges) for phase in (1.0, -1j))
    return (edges + np.append(edges[1:], n) - 1) / 2, real - 1j * imaginary


def _factors(n: int, turns: float) -> tuple[Complex, Complex]:
    """Return exp(2 pi i turns k) of the multiples of m below n, and of the rests."""
    m = int(np.ceil(np.sqrt(n)))
    coarse, fine = (np.exp(2j * np.pi * (turns * k % 1.0)) for k in (np.arange(0, n, m), np.arange(m)))
    return coarse, fine
