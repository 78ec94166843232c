"""Blocks of one channel that are livelier than the channel's own quiet: where a dwell was disturbed.

Of a channel whose remainder is not white, as of counts with little noise, a block is judged by the strip its
counts need (`procedures.anomalies.disturbed_blocks`); of any other by its variance, that of as many numbers as
the scatter of all blocks' variances shows. Noise and variance are those of the channel's quieter
dwells, so that a shock does not hide itself.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from procedures.arrays import FloatArray, IntArray
from procedures.counts.count_noise import MIN_WHITE_NOISE, WHITE_LAG_SAMPLES, lag_sums
from procedures.counts.count_rate import MIN_DWELL_SAMPLES, estimate_counts
from procedures.inference import odds, priors
from procedures.inference.marginal import log_mean

GOLDEN_RATIO = (np.sqrt(5) - 1) / 2
SLOPE_ITERATIONS = 20  # the bracket shrinks to 1e-4 of a count
BEND_ITERATIONS = 14
# Counts per half block either side of least squares, which is never further off
SLOPE_REACH, BEND_REACH = 2.0, 1.0
# Kuiper's range v of a walk has the tail 2 (4 v^2 - 1) exp(-2 v^2): as of four numbers whose squares' sum is 4 v^2
NUMBERS_OF_RANGE = 4.0


def strip_width(count: FloatArray) -> FloatArray:
    """Return the width (m,) [counts] of the narrowest straight strip about cumulative counts ``count`` (m, n)."""
    x = np.linspace(-1, 1, count.shape[1])
    level = count - count.mean(axis=1, keepdims=True)
    start = level @ x / (x @ x)
    return _least(lambda slope: _height(level - slope[:, None] * x), start, SLOPE_REACH, SLOPE_ITERATIONS)


def bent_strip_width(count: FloatArray) -> FloatArray:
    """Return the width (m,) [counts] of the narrowest strip about a parabola in ``count`` (m, n) [counts]."""
    x = np.linspace(-1, 1, count.shape[1])
    bend = x**2 - np.mean(x**2)
    level = count - count.mean(axis=1, keepdims=True)
    start = level @ bend / (bend @ bend)
    return _least(lambda q: strip_width(level - q[:, None] * bend), start, BEND_REACH, BEND_ITERATIONS)


def gain_of_width(width: FloatArray, noise: float, samples: int) -> FloatArray:
    """Return the gain (m,) of a disturbance by strips' ``width`` (m,) [counts]; noise in counts / sqrt(sample)."""
    v = np.maximum((width - 1) / (noise * np.sqrt(samples)), 0.0)
    return odds.gain_of_squares(4 * v**2, NUMBERS_OF_RANGE)


def _height(level: FloatArray) -> FloatArray:
    height: FloatArray = level.max(axis=1) - level.min(axis=1)
    return height


def _least(
    height: Callable[[FloatArray], FloatArray], middle: FloatArray, reach: float, rounds: int
) -> FloatArray:
    """Return the least (m,) of m convex functions within ``reach`` of ``middle`` (golden section)."""
    low, high = middle - reach, middle + reach
    left, right = high - GOLDEN_RATIO * (high - low), low + GOLDEN_RATIO * (high - low)
    at_left, at_right = height(left), height(right)
    for _ in range(rounds):
        falls = at_left > at_right
        low, high = np.where(falls, left, low), np.where(falls, high, right)
        new = np.where(falls, low + GOLDEN_RATIO * (high - low), high - GOLDEN_RATIO * (high - low))
        at_new = height(new)
        left, right = np.where(falls, right, new), np.where(falls, new, left)
        at_left, at_right = np.where(falls, at_right, at_new), np.where(falls, at_new, at_left)
    return np.minimum(at_left, at_right)


BLOCK_LENGTHS_S = (1.0, 2.0, 5.0, 10.0)  # s, of blocks
MIN_BLOCK_SAMPLES = 12  # samples a block
MAX_STRIP_NODES = 128  # of a block's strip: denser counts say little more
MIN_NOISE, NOISE_MARGIN = 5e-4, 1.5  # counts per sqrt(sample): few edges leave a smaller one open; factor
MAX_QUIET_RATIO = 1.3  # times the channel's variance, up to which a dwell's own is taken for its quiet
QUIET_VARIANCE_SIGMAS = 2.0  # sigmas by which the quiet variance may be larger than was found
OUTERMOST, MIN_OUTERMOST = 0.02, 10  # of a soak's blocks, beyond which they are predicted; at least so many
FIFTH = 0.2  # the same of variances by the middle half of the samples, which have no tails
STD_OF_MIDDLE_HALF = 1.349  # by how many sigmas a normal distribution's quartiles are apart
MIN_FINE = 100.0  # times the variance of rounding, from which on quartiles are no matter of it: 5 steps of sigma
OF_THE_MIDDLE = 0.37  # of the samples: quartiles tell a variance as well as so many do
POWER_SIGMAS, LEAST_SURE = 2.0, 0.5  # by which the power of the tail may be less than it is found
TAIL = 5.0  # times as many blocks, from which on the tail is taken


@dataclass(frozen=True, slots=True, eq=False)
class ChannelSamples:
    """One channel in one step: ``values`` (n,) a sample, ``starts`` of segments, ``period`` [s]."""

    values: FloatArray
    starts: IntArray
    period: float


@dataclass(frozen=True, slots=True, eq=False)
class JudgedBlocks:
    """Blocks of one length: the trace, the first sample and the end of each, and its gain (m,)."""

    trace: IntArray
    first: IntArray
    end: IntArray
    gain: FloatArray


def judge_blocks(traces: Sequence[ChannelSamples], counts: bool, *, is_soak: bool = False) -> list[JudgedBlocks]:
    """Judge all blocks of one channel's traces; shortest blocks first.

    Of a soak's many blocks the liveliest are held against the tail that the others foretell as well.
    """
    if counts and not is_white(traces):
        return _by_strip(traces)
    return _by_variance(traces, counts, is_soak)


def is_white(traces: Sequence[ChannelSamples]) -> bool:
    """Say whether most traces' noise is so large that the counts' remainder is white (as `count_rate`)."""
    slow = list[float]()
    for trace in traces:
        sums = lag_sums(trace.values)
        slow.append(float(np.mean(np.diff(sums) ** 2)) if len(sums) > 1 else 0.0)
    return bool((np.median(slow) - 0.5) / (2 * WHITE_LAG_SAMPLES) > MIN_WHITE_NOISE**2)


def _windows(
    traces: Sequence[ChannelSamples], seconds: float, more: int
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Return trace, first and end of half-overlapping blocks, their samples (m, L); ``more`` 1: L + 1 nodes."""
    length = round(seconds / traces[0].period)
    at, first, rows = list[IntArray](), list[IntArray](), [np.zeros((0, length + more))]
    for number, trace in enumerate(traces):
        for begin, end in zip(trace.starts, [*trace.starts[1:], len(trace.values)], strict=True):
            values = trace.values[begin:end]
            if len(values) < length or length < MIN_BLOCK_SAMPLES:
                continue
            nodes = np.concatenate(([0.0], np.cumsum(values))) if more else values
            every = max(length // 2, 1)
            rows.append(sliding_window_view(nodes, length + more)[::every])
            first.append(begin + every * np.arange(len(rows[-1])))
            at.append(np.full(len(rows[-1]), number))
    if not first:
        nothing = np.zeros(0, dtype=np.int64)
        return nothing, nothing, nothing, rows[0]
    begins = np.concatenate(first)
    return np.concatenate(at), begins, begins + length, np.concatenate(rows)


def _by_strip(traces: Sequence[ChannelSamples]) -> list[JudgedBlocks]:
    found, widths = list[JudgedBlocks](), list[tuple[IntArray, IntArray, IntArray, FloatArray, FloatArray]]()
    for seconds in BLOCK_LENGTHS_S:
        at, first, end, nodes = _windows(traces, seconds, 1)
        nodes = nodes[:, :: max(nodes.shape[1] // MAX_STRIP_NODES, 1)]
        nodes = nodes - nodes[:, :1]
        widths.append((at, first, end, nodes, strip_width(nodes) if len(nodes) else np.zeros(0)))
    noise = _noise(traces, [(at, width) for at, *_, width in widths])
    for at, first, end, nodes, width in widths:
        samples = int(end[0] - first[0]) if len(first) else 1
        gain = gain_of_width(width, noise, samples)
        again = gain > 0
        if again.any():
            gain[again] = gain_of_width(bent_strip_width(nodes[again]), noise, samples)
        found.append(JudgedBlocks(at, first, end, gain))
    return found


def _noise(traces: Sequence[ChannelSamples], widths: Sequence[tuple[IntArray, FloatArray]]) -> float:
    """Return the noise [counts per sqrt(sample)] of the half of the traces whose strips are narrowest."""
    widest = np.zeros(len(traces))
    for at, width in widths:
        np.maximum.at(widest, at, width)
    quiet = [traces[i] for i in np.argsort(widest)[: (len(traces) + 1) // 2]]
    quiet = [trace for trace in quiet if len(trace.values) >= MIN_DWELL_SAMPLES]
    if not quiet:
        return np.inf
    period = traces[0].period
    values = [trace.values.astype(np.int64) for trace in quiet]
    estimate = estimate_counts(values, period, [trace.starts for trace in quiet])[0]
    return max(NOISE_MARGIN * estimate.noise * float(np.sqrt(period)), MIN_NOISE)


def _by_variance(traces: Sequence[ChannelSamples], counts: bool, is_soak: bool = False) -> list[JudgedBlocks]:
    found, step = list[JudgedBlocks](), rounding_of([trace.values for trace in traces])
    rounding = 0.0 if counts else step
    least = MIN_BLOCK_SAMPLES * traces[0].period if is_soak else 0.0  # a slow log has longer blocks
    for seconds in sorted({max(each, least) for each in BLOCK_LENGTHS_S}):
        at, first, end, samples = _windows(traces, seconds, 0)
        if not len(samples):
            continue
        gain, ratio = _gain_of(samples.var(axis=1, ddof=1), samples.shape[1], at, len(traces), rounding)
        if is_soak:
            gain = np.minimum(gain, _gain_of_tail(ratio, OUTERMOST))
            middle = middle_half(samples)
            if float(np.median(middle)) > MIN_FINE * step:
                as_good_as = max(int(OF_THE_MIDDLE * samples.shape[1]), 2)
                other, of_middle = _gain_of(middle, as_good_as, at, len(traces), step)
                gain = log_mean(np.stack((gain, np.minimum(other, _gain_of_tail(of_middle, FIFTH))), axis=-1))
        found.append(JudgedBlocks(at, first, end, gain))
    return found


def _gain_of(
    variance: FloatArray, samples: int, at: IntArray, traces: int, rounding: float
) -> tuple[FloatArray, FloatArray]:
    """Return the gain by the variances (m,) of blocks of so many samples, and each over its trace's quiet (m,)."""
    quiet = _quiet_variance(variance, at, traces) + rounding
    ratio = variance / quiet[at] if np.all(quiet > 0) else np.ones(len(at))
    dof = _degrees(ratio, samples - 1)
    ratio = ratio / _at_most(dof, len(at) / traces)
    return odds.gain_of_squares(dof * ratio, dof), ratio


def middle_half(samples: FloatArray) -> FloatArray:
    """Return the variance (m,) by the middle half of each block's samples (m, n): few far off are none of it."""
    quarter = samples.shape[1] // 4
    ranked = np.partition(samples, (quarter, samples.shape[1] - 1 - quarter), axis=1)
    found: FloatArray = ((ranked[:, -1 - quarter] - ranked[:, quarter]) / STD_OF_MIDDLE_HALF) ** 2
    return found


def _at_most(dof: float, blocks: float) -> float:
    """Return how much larger than the median of a trace's ``blocks`` variances their mean may be.

    The median of chi-square over its mean is (1 - 2 / (9 dof))^3 (Wilson and Hilferty 1931); it is known to
    sqrt(pi / 2) times sqrt(2 / dof) over the root of the blocks that do not overlap, half of all. Without both the
    liveliest of thousands of blocks is a shock in one quiet campaign of fifty.
    """
    return float((1 + QUIET_VARIANCE_SIGMAS * np.sqrt(2 * np.pi / (dof * blocks))) / (1 - 2 / (9 * dof)) ** 3)


def _gain_of_tail(ratio: FloatArray, outermost: float) -> FloatArray:
    """Return the gain by variances (m,) next to the power law of their tail, up to the ``outermost`` part of them.

    Noise with tails, as of bursts, has blocks livelier than chi-square knows of: its largest are no shocks. A
    shock is as likely of any size, in its logarithm.
    """
    outer = min(max(outermost, MIN_OUTERMOST / len(ratio)), 0.4)
    inner = min(TAIL * outer, 0.5)
    first, last = np.maximum(np.percentile(ratio, (100 * (1 - inner), 100 * (1 - outer))), 1e-12)
    sure = 1 - POWER_SIGMAS / np.sqrt(len(ratio) * inner / 2)  # of overlapping blocks
    power = max(sure, LEAST_SURE) * np.log(inner / outer) / max(float(np.log(last / first)), 1e-12)
    of_noise = np.log(outer * power) - power * np.log(np.maximum(ratio, last) / last)
    gain: FloatArray = np.where(ratio > last, -np.log(2 * np.log(priors.SPAN)) - of_noise, 0.0)
    return gain


def rounding_of(values: Sequence[FloatArray]) -> float:
    """Return the variance that an output, ``values`` (n,) each, flickering between two neighbours has at most.

    A rounded output with little noise comes to it, and leaves it, as its mean drifts.
    """
    levels = np.unique(np.concatenate([np.unique(each) for each in values]))
    return float(np.diff(levels).min()) ** 2 / 4 if len(levels) > 1 else 0.0


def _quiet_variance(variance: FloatArray, at: IntArray, traces: int) -> FloatArray:
    """Return the quiet variance of each trace: its own median, unless that is beyond what the channel has."""
    own = np.array([np.median(variance[at == i]) if np.any(at == i) else np.nan for i in range(traces)])
    channel = float(np.nanmedian(own))
    return np.where(own < MAX_QUIET_RATIO * channel, own, channel)


def _degrees(ratio: FloatArray, most: int) -> float:
    """Return the degrees of freedom that the middle half of the variances shows: var(ln s^2) is 2 / dof."""
    low, high = np.percentile(np.log(np.maximum(ratio, 1e-12)), (25, 75))
    spread = (high - low) / 1.349
    return float(np.clip(2 / spread**2 if spread > 0 else most, 1.0, most))
