"""Columns of a bias that walks at random: a step of one variance between any two places of a recording."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.residual_rows import Evidence
from procedures.effects.effect import Columns, Excitation, per_axis
from procedures.units import S_PER_H

RESTING = ("dwell", "rest")

PARTS = 4  # of a dwell or rest, before each of which a walk steps


def walk_columns(evidence: Evidence, triad: str, parts: int = 1) -> FloatArray:
    """Return what a walk of a triad's biases by 1 [g, deg/s] in an hour's root adds to every row (n, k).

    A column is a step in one sensor, before each step of the recording but the first, as large as its time allows;
    with ``parts`` also before each part of a dwell or rest, within which a walk makes slopes.
    """
    seen, found = evidence.excitation, list[FloatArray]()
    history = seen.histories
    for one in np.unique(history):
        here = history[seen.step] == one
        for earlier, later in pairwise(sorted(_places(seen, np.flatnonzero(history == one), parts))):
            if later > earlier:
                after = here & (seen.t >= later)
                found.append(np.sqrt((later - earlier) / S_PER_H) * per_axis(after.astype(float)))
    if not found:
        return np.zeros((len(evidence.residual), 0))
    values = np.concatenate(found, axis=2)
    names = tuple(str(i) for i in range(values.shape[2]))
    is_accel = triad == "accelerometer"
    return evidence.column(Columns(names, accel=values) if is_accel else Columns(names, gyro=values))


def _places(seen: Excitation, steps: np.ndarray, parts: int) -> Iterator[float]:
    """Yield the times [s] before which a walk steps: at the beginnings of ``steps``, and in rests."""
    for number in steps:
        t = seen.t[seen.step == number]
        if len(t):
            first, last = float(np.min(t)), float(np.max(t))
            several = parts if seen.steps[number].kind in RESTING else 1
            yield from (first + part / several * (last - first) for part in range(several))
