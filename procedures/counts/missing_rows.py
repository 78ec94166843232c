"""Rows without a sample: samples that were lost, and triads of unlike sample rates.

A few rows that are missing in sequence are samples whose times are known. They are bridged by straight lines, so
that a recording stays whole, and marked: their values hold no noise, and no noise is computed from them.
"""

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray, true_runs
from procedures.counts.sample_times import GAP_PERIODS, own_period, sample_times

INTERPOLATED = "interpolated"  # column of a series: the sum of the bits of the triads whose values are no samples
TRIAD_BITS = {"gyroscope": 1, "accelerometer": 2}
MOST_LOST = 3  # rows in sequence that are bridged
MAX_BRIDGED = 0.25  # of the rows: of more the times and the slow terms of the noise are no longer good
WHOLE = 0.25  # sample periods that a gap may be off a whole number of them
REGULAR_STAMPS = 0.99  # of the steps, that are a whole number of periods
ROWS_AHEAD = 8  # over which the lateness of a lost row lasts; stamps that were late catch up
MIN_REGULAR = 0.9  # of the steps from one row of the slower triad to the next, that are alike
COARSE_LEVELS = 256  # of a channel: a value between two would be a level that it does not have
MAX_STEPS = 4  # of these steps, across which the slower triad is still known


def rows_lost(t: FloatArray) -> IntArray:
    """Return how many samples are missing (n,) before each row at ``t`` (n,) [s]; 0 before a longer gap."""
    lost = np.zeros(len(t), dtype=np.int64)
    step = np.diff(t)
    if len(t) < 3 or not (step > 0).all() or step.max() <= GAP_PERIODS * (period := float(np.median(step))):
        return lost
    whole = np.maximum(np.rint(step / period), 1.0)
    if np.mean(np.abs(step / period - whole) < WHOLE) >= REGULAR_STAMPS:
        begins = np.flatnonzero(whole > 1) + 1
        begins = begins[_lateness(t, begins, period) > whole[begins - 1] - 1 - WHOLE]
        periods = step[begins - 1] / period
    else:  # stamps of reads: where their lateness lasts is looked at more closely
        found = sample_times(t, own_period(t))
        begins = found.begins[1:]
        periods = (found.t[begins] - found.t[begins - 1]) / found.period
    count = np.rint(periods).astype(np.int64) - 1
    is_short = (count >= 1) & (count <= MOST_LOST) & (np.abs(periods - count - 1) < WHOLE)
    lost[begins[is_short]] = count[is_short]
    return lost


def _lateness(t: FloatArray, begins: IntArray, period: float) -> FloatArray:
    """Return by how many periods rows at ``t`` (n,) [s] from ``begins`` (m,) on are late, at the least (m,)."""
    ahead = np.minimum(begins[:, None] + np.arange(ROWS_AHEAD), len(t) - 1)
    late = (t[ahead] - t[begins - 1][:, None]) / period - (ahead - begins[:, None] + 1)
    least: FloatArray = late.min(axis=1)
    return least


def rows_of_slower(there: BoolArray) -> BoolArray | None:
    """Mark [rows] (n,) in which a triad is known that is ``there`` (n,) in every k-th row; None of another."""
    at = np.flatnonzero(there)
    step = np.diff(at)
    if len(step) < 2 or (usual := int(np.median(step))) < 2 or np.mean(step == usual) < MIN_REGULAR:
        return None
    known = np.zeros(len(there), dtype=np.bool_)
    for begin, end in true_runs(np.concatenate((step <= MAX_STEPS * usual, [False]))).tolist():
        known[at[begin] : at[end] + 1] = True
    return known


def bridged(t: FloatArray, times: FloatArray, values: FloatArray) -> FloatArray:
    """Return values at other times, straight in between; of few levels the nearest one.

    Parameters
    ----------
    t : (n,) [s], where values are wanted
    times : (m,) [s], rising
    values : (m,), of any unit
    """
    line = np.interp(t, times, values)
    levels = np.unique(values)
    if len(levels) > COARSE_LEVELS:
        return line
    middles = (levels[1:] + levels[:-1]) / 2
    nearest: FloatArray = levels[np.searchsorted(middles, line)]
    return nearest
