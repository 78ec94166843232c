"""Columns of a bias that walks at random: a step of one variance between any two steps of a recording."""

from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.residual_rows import Evidence
from procedures.effects.effect import Columns, per_axis
from procedures.units import S_PER_H


def walk_columns(evidence: Evidence, triad: str) -> FloatArray:
    """Return what a walk of a triad's biases by 1 [g, deg/s] in an hour's root adds to every row (n, k).

    A column is a step in one sensor, before each step of the recording but the first, as large as its time allows.
    """
    seen, found = evidence.excitation, list[FloatArray]()
    history, numbers = seen.histories, np.arange(len(seen.steps))
    begins = np.array([float(np.min(seen.t[seen.step == n])) for n in numbers])
    for one in np.unique(history):
        order = sorted((n for n in numbers if history[n] == one), key=lambda n: begins[n])
        for earlier, later in pairwise(order):
            after = (history[seen.step] == one) & (begins[seen.step] >= begins[later])
            if begins[later] > begins[earlier]:
                hours = (begins[later] - begins[earlier]) / S_PER_H
                found.append(np.sqrt(hours) * per_axis(after.astype(float)))
    if not found:
        return np.zeros((len(evidence.residual), 0))
    values = np.concatenate(found, axis=2)
    names = tuple(str(i) for i in range(values.shape[2]))
    is_accel = triad == "accelerometer"
    return evidence.column(Columns(names, accel=values) if is_accel else Columns(names, gyro=values))
