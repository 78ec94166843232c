"""Straight lines that pass every count's interval: what a dwell near a simple fraction of a count per sample says.

At half a count per sample the count's pattern repeats every two samples, and a rate a little beside shows only
where the pattern slips. Few slips leave a wedge of lines, as few edges do near a whole count, and a Gaussian is
narrower than that by a third. The lines that fit are counted instead: each is as likely as any other.
"""

import numpy as np

from procedures.arrays import FloatArray

REACH, STEP = 8.0, 0.1  # of the sigma given: how far beside it lines are tried, and how densely


def rate_within_counts(
    t: FloatArray, low: FloatArray, linked: FloatArray, mean: float, std: float
) -> tuple[float, float] | None:
    """Return mean and 1 sigma of the slopes of the lines that fit [counts per sample]; None where none does.

    A slope is as likely as the room that it leaves its line is wide: in each gap-free segment the line lies
    between the highest of ``low`` and the lowest of ``low`` + 1, and each segment has a level of its own.

    Parameters
    ----------
    t, low : nodes (m,): time [samples], and the least that the output can have been there [counts]
    linked : (m,) 1 where a node continues a segment, else 0
    mean, std : about where the slopes are [counts per sample]
    """
    slopes = mean + std * np.arange(-REACH, REACH + STEP, STEP)
    remainder = low - slopes[:, None] * t
    starts = np.flatnonzero(linked == 0)
    room = 1 + np.minimum.reduceat(remainder, starts, axis=1) - np.maximum.reduceat(remainder, starts, axis=1)
    weight = np.prod(np.maximum(room, 0.0), axis=1)
    if not weight.any():
        return None
    weight /= weight.sum()
    centre = float(weight @ slopes)
    return centre, float(np.sqrt(weight @ (slopes - centre) ** 2))
