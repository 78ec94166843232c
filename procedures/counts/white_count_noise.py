"""Is a counter's noise so large that what stays of a count is white? Then the counts are a rate with noise."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import IntArray
from procedures.counts.sample_records import Samples

MIN_WHITE_NOISE = 0.35  # counts per sqrt(sample) above which the remainder is white: its harmonic is e^-2(pi s)^2
WHITE_LAG_SAMPLES = 16  # samples


def white_count_noise(dwells: Sequence[IntArray]) -> float:
    """Return the noise [counts/sqrt(sample)] if it is large enough to make the remainder white, else 0.

    An increment is r + w + q' - q with q uniform of variance 1/12: half the mean square of the increments'
    differences is s^2 + 3/12. A rate near a simple fraction imitates that, but not over `WHITE_LAG_SAMPLES`
    samples, where a remainder that only repeats cannot pass `MIN_WHITE_NOISE`; nor does it ever change an
    increment by more than 2. ``dwells`` are increments (n,) of each dwell, counts per sample.
    """
    fast = _mean_square([np.diff(d) for d in dwells]) / 2 - 0.25
    long = [np.diff(lag_sums(d)) for d in dwells if len(d) > 2 * WHITE_LAG_SAMPLES]
    if not long:
        beyond = max(int(np.abs(np.diff(d)).max(initial=0)) for d in dwells) > 2
        return float(np.sqrt(fast)) if beyond else 0.0
    slow = (_mean_square(long) - 0.5) / (2 * WHITE_LAG_SAMPLES)
    if slow < MIN_WHITE_NOISE**2:
        return 0.0
    return float(np.sqrt(fast if fast > MIN_WHITE_NOISE**2 else slow))  # slow alone: a step, as from a knock


def lag_sums(increments: Samples) -> Samples:
    """Return the sums (m,) of each `WHITE_LAG_SAMPLES` of ``increments`` (n,) [count]."""
    whole = len(increments) // WHITE_LAG_SAMPLES
    sums: Samples = increments[: whole * WHITE_LAG_SAMPLES].reshape(-1, WHITE_LAG_SAMPLES).sum(axis=1)
    return sums


def _mean_square(parts: Sequence[IntArray]) -> float:
    return float(sum(np.sum(part**2.0) for part in parts) / sum(len(part) for part in parts))
