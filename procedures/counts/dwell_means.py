"""The mean output of a dwell with its standard uncertainty: under vibration, and of a rate output.

Dwells share a channel's white noise, but for one that a machine nearby makes livelier. Its strongest lines are
fitted with a parabola, their frequencies as well, by least squares, and what they leave determines its noise.
Under a line that is many counts high rounding is white (dither): a count is then the middle of its interval, give
or take sqrt(1/12).
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.count_noise import WHITE_LAG_SAMPLES, lag_sums
from procedures.counts.count_rate import RateEstimate
from procedures.statistics.spectrum import sine

TIMES_LIVELIER = 4.0  # than the quiet dwells, by the scatter of samples or of sums of some
ROUNDED = 0.5  # of a step: what rounding alone makes of either
MIN_COMPARED = 32  # samples, or sums of some, of which a scatter is one
QUIET = 0.2  # of the dwells at the least that are quiet
MAX_LINES = 4  # of a dwell
PADDING = 4  # times as many frequencies as samples
REFINED = 8  # rounds of Gauss and Newton
MIN_PERIODS = 3.0  # of a line in a dwell
MIN_SUMS, ROUNDING = 8, 0.5  # of samples; variance of their differences by rounding [count^2]
SIGMAS = 3.0  # by which their scatter must exceed what all dwells share; a variance of m differences has 3 / m
MIN_STANDING = 30.0  # times the median of a spectrum by which a line stands out


def shaken(dwells: Sequence[FloatArray], step: float) -> list[bool]:
    """Say which of one channel's ``dwells`` (n,) of samples are livelier by far than the quiet ones.

    ``step`` is by how much two outputs differ at the least, in the samples' unit.
    """
    values = [np.asarray(each, dtype=np.float64) for each in dwells]
    scatter = np.array([[_scatter(each), _scatter(lag_sums(each))] for each in values])
    compared = np.array([[len(each), len(lag_sums(each))] for each in values]) >= MIN_COMPARED
    livelier = np.zeros(len(values), dtype=bool)
    for column in (0, 1):
        known = scatter[compared[:, column], column]
        if len(known) > 1:  # a short dwell says nothing of how quiet the others are
            quiet = max(float(np.quantile(known, QUIET, method="lower")), ROUNDED * step)
            livelier |= compared[:, column] & (scatter[:, column] > TIMES_LIVELIER * quiet)
    return [bool(each) for each in livelier & ~livelier.all()]


def _scatter(values: FloatArray) -> float:
    """Return the scatter (1 sigma) of neighbours, in the samples' unit."""
    return float(np.sqrt(np.mean(np.diff(values) ** 2) / 2)) if len(values) > 1 else 0.0


def without_lines(values: FloatArray) -> FloatArray:
    """Return ``values`` (n,) in any unit less the lines that stand out of them, mean, slope and bend left in."""
    n = len(values)
    x = np.linspace(-1.0, 1.0, n)
    smooth = np.stack((np.ones(n), x, x**2), axis=1)
    left, turns = _left(values, smooth), list[float]()
    for _ in range(MAX_LINES):
        line = _strongest(left)
        if line is None:
            break
        turns = _refined(values, smooth, [*turns, line])
        left = _left(values, np.hstack((smooth, _waves(n, turns))))
    if not turns:
        return values
    waves = _waves(n, turns)
    c = _fitted(np.hstack((smooth, waves)), values)
    return values - waves @ c[smooth.shape[1] :]


def count_noise(values: FloatArray, shared: float) -> float:
    """Return the noise [count/sqrt(sample)] of counts ``values`` (n,) less lines: ``shared`` unless it is more.

    Sums of `WHITE_LAG_SAMPLES` m differ by ``2 m s^2`` and what rounding adds, 1/2.
    """
    sums = lag_sums(values)
    if len(sums) < MIN_SUMS:
        return max(_scatter(values), shared)
    square, expected = float(np.mean(np.diff(sums) ** 2)), ROUNDING + 2 * WHITE_LAG_SAMPLES * shared**2
    if square < expected * (1 + SIGMAS * np.sqrt(3 / len(sums))):
        return shared
    return float(np.sqrt((square - ROUNDING) / (2 * WHITE_LAG_SAMPLES)))


def _left(values: FloatArray, design: FloatArray) -> FloatArray:
    return values - design @ _fitted(design, values)


def _fitted(design: FloatArray, values: FloatArray) -> FloatArray:
    """Return least squares' coefficients (k,), by normal equations of columns of one size.

    Thousands of rows by a dozen columns, again in every round: an SVD of them takes ten times as long.
    """
    gram = design.T @ design
    size = np.sqrt(gram.diagonal())
    size[size == 0] = 1.0
    found: FloatArray = np.linalg.lstsq(gram / np.outer(size, size), design.T @ values / size, rcond=None)[0]
    return found / size


def _waves(n: int, turns: Sequence[float]) -> FloatArray:
    """Return cosine and sine (n, 2 k) of frequencies [turns per sample], from the middle on."""
    waves = np.empty((n, 2 * len(turns)))
    _fill_waves(waves, turns)
    return waves


def _fill_waves(waves: FloatArray, turns: Sequence[float]) -> None:
    middle = [np.exp(-1j * np.pi * len(waves) * each) for each in turns]
    both = ((by, t, phase) for by in (1.0, -1j) for t, phase in zip(turns, middle, strict=True))
    for column, (by, t, phase) in enumerate(both):
        waves[:, column] = sine(len(waves), t, by * phase)


def _strongest(left: FloatArray) -> float | None:
    """Return the frequency [turns per sample] of the strongest line that stands out, None where none does."""
    n = len(left)
    power = np.abs(np.fft.rfft(left * np.hanning(n), PADDING * n)) ** 2
    power[: int(MIN_PERIODS * PADDING)] = 0.0
    best = int(np.argmax(power))
    return best / (PADDING * n) if power[best] > MIN_STANDING * np.median(power) else None


def _refined(values: FloatArray, smooth: FloatArray, turns: Sequence[float]) -> list[float]:
    """Return frequencies [turns per sample] fitted with the amplitudes (Gauss-Newton)."""
    n, k, found = len(values), len(turns), np.array(turns)
    time, level = 2 * np.pi * (np.arange(n) - n / 2), smooth.shape[1]
    design = np.empty((n, level + 3 * k))
    design[:, :level] = smooth
    cosines, sines, slopes = (design[:, level + i * k : level + (i + 1) * k] for i in range(3))
    for _ in range(REFINED):
        _fill_waves(design[:, level : level + 2 * k], found.tolist())
        c = _fitted(design[:, : level + 2 * k], values)[level:]
        np.subtract(cosines * c[k:], sines * c[:k], out=slopes)
        slopes *= time[:, None]
        step = _fitted(design, values)[-k:]
        found = np.clip(found + np.clip(step, -1 / n, 1 / n), MIN_PERIODS / n / 2, 0.5)
        if np.max(np.abs(step)) < 1e-4 / n:
            break
    return [float(each) for each in found]


# Of a dwell: their scatter is known to 7 %, and they are long enough to average a filter out
MIN_DWELL_BLOCKS = 128


def estimate_rates(dwells: Sequence[FloatArray], period: float) -> list[RateEstimate]:
    """Estimate the mean of one channel in each of several ``dwells`` (n,) of samples, in any unit of rate.

    The white noise, shared by all dwells, is taken from the Allan variance of the longest blocks of which every
    dwell holds `MIN_DWELL_BLOCKS` (NIST SP 1065, 5.2). It is at least what rounding to the output's own step
    leaves.
    """
    values = [np.asarray(dwell, dtype=np.float64) for dwell in dwells]
    scatter = np.sqrt(np.mean([_white(each, max(len(each) // MIN_DWELL_BLOCKS, 1)) ** 2 for each in values]))
    white = float(max(scatter, output_step(values) / np.sqrt(12 * min(len(each) for each in values))))
    return [_estimate(each, white, period) for each in values]


def _estimate(values: FloatArray, white: float, period: float) -> RateEstimate:
    n = len(values)
    x = (2 * np.arange(n) + 1) / n - 1
    polynomials = np.stack([x, (3 * x**2 - 1) / 2])
    slope, curvature = (polynomials @ (values - values.mean())) / np.sum(polynomials**2, axis=1)
    std, half = white / np.sqrt(n), n * period / 2
    return RateEstimate(
        rate=float(values.mean()), std=std, slope=float(slope) / half, slope_std=float(np.sqrt(3)) * std / half,
        curvature=3 * float(curvature) / half**2, curvature_std=3 * float(np.sqrt(5)) * std / half**2,
        noise=white * float(np.sqrt(period)), edges=n,
    )  # fmt: skip


def _white(values: FloatArray, length: int) -> float:
    """Return the white noise of a sample that the scatter of neighbouring blocks of ``length`` implies."""
    blocks = values[: len(values) // length * length].reshape(-1, length).mean(axis=1)
    return float(np.sqrt(length * np.mean(np.diff(blocks) ** 2) / 2)) if len(blocks) > 1 else 0.0


def output_step(values: Sequence[FloatArray]) -> float:
    """Return the smallest difference between two ``values`` (n,), in their unit; of one, its resolution."""
    levels = np.unique(np.concatenate([np.unique(each) for each in values]))
    if len(levels) > 1:
        return float(np.diff(levels).min())
    return float(np.spacing(max(abs(float(levels[0])), 1.0)))
