"""The sine in counts, from what every count says for certain: the output lay in ``[c, c + 1)``.

At a given frequency the outputs ``line + bend + a_c cos + a_s sin`` that all counts of a stretch allow are a
convex set; the middle of its extent in a_c and a_s is the estimate, half of its half extent the sigma, to which is
added what no sine explains. Counts at a low rate, whose remainder is a sawtooth with lines of its own, are no
different. Each bound is a linear programme.
"""

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


def strip_beside(running: FloatArray, hertz: float, period: float, first: int, end: int) -> float:
    """Return the strips, summed over axes, that ``running`` counts (n, 3) need beside a sine.

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
    """Return where the middle `MAX_NODES` of a stretch begin, and these beside the first of them."""
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
