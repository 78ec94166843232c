"""How far counts are from those of an even rate: the width of the narrowest strip that holds them.

The cumulative count c is the integer part of an output, so of an output that is a straight line all points (t, c)
lie within a strip less than one count high, whatever its rate and remainder (they are a digital straight line).
Of a line plus any w they lie within ``1 + strip(w)``. Where w is the random walk of white rate noise, s per square
root of a sample, its strip over L samples is no wider than the range of a Brownian bridge, of which Kuiper gave
the distribution: a bound on the probability of what is seen that takes nothing for granted of rate or remainder.
What a knock does shows hundreds of times below the variance that quantisation leaves in the increments.

Source: N. H. Kuiper, Proc. Kon. Ned. Akad. Wet. A 63, 1960; the use made of it is this project's own.
"""

from collections.abc import Callable

import numpy as np

from procedures.arrays import FloatArray

GOLDEN_RATIO = (np.sqrt(5) - 1) / 2
SLOPE_ITERATIONS = 20  # the bracket shrinks to 1e-4 of a count
BEND_ITERATIONS = 14
# Counts per half block either side of least squares, which is never further off
SLOPE_REACH, BEND_REACH = 2.0, 1.0
MIN_KUIPER_STATISTIC = 0.9  # of Kuiper's statistic, below which its leading term is no probability


def strip_width(count: FloatArray) -> FloatArray:
    """Return the width (m,) of the narrowest straight strip about cumulative counts (m, n) of m blocks."""
    x = np.linspace(-1, 1, count.shape[1])
    level = count - count.mean(axis=1, keepdims=True)
    start = level @ x / (x @ x)
    return _least(lambda slope: _height(level - slope[:, None] * x), start, SLOPE_REACH, SLOPE_ITERATIONS)


def bent_strip_width(count: FloatArray) -> FloatArray:
    """Return the width (m,) of the narrowest strip about a parabola: what a rate that drifts leaves."""
    x = np.linspace(-1, 1, count.shape[1])
    bend = x**2 - np.mean(x**2)
    level = count - count.mean(axis=1, keepdims=True)
    start = level @ bend / (bend @ bend)
    return _least(lambda q: strip_width(level - q[:, None] * bend), start, BEND_REACH, BEND_ITERATIONS)


def log_p_of_width(width: FloatArray, noise: float, samples: int) -> FloatArray:
    """Return an upper bound (m,) of ln P of strips at least as wide as ``width`` (m,) [counts].

    ``noise`` is in counts per sqrt(sample).
    """
    v = np.maximum((width - 1) / (noise * np.sqrt(samples)), MIN_KUIPER_STATISTIC)
    found: FloatArray = np.minimum(np.log(2 * (4 * v**2 - 1)) - 2 * v**2, 0.0)
    return found


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
