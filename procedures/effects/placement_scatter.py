"""Seats scatter: in every dwell and turn the IMU in the cube, or the cube on the slab, leans by a draw of its own.

One variance for both level axes, fitted. A turn then goes about another axis of the IMU. Plausible: 1e-4 rad, 0.04
mm on 400 mm.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation, rotation_columns
from procedures.frames import AXES, cross_axes


def columns(excitation: Excitation) -> list[Columns]:
    """Return each dwell and turn tilted about the two level axes of the cube [g and deg/s per rad]."""
    seats = [
        (number, step, axis)
        for number, step in enumerate(excitation.steps)
        if step.position and step.kind in {"dwell", "turn"}
        for axis in cross_axes(step.face)
    ]
    if not seats:
        return []
    leaning = np.zeros((len(excitation.t), 3, len(seats)))
    for i, (number, _, axis) in enumerate(seats):
        here = excitation.step == number
        leaning[here, :, i] = excitation.C_sb[here, :, axis]
    names = [f"{step.campaign + 1}.{step.name}.{AXES[axis]}" for _, step, axis in seats]
    accel, gyro = rotation_columns(excitation, leaning)
    return [Columns(tuple(names), accel=accel, gyro=gyro, rotation=leaning)]


EFFECT = Effect(
    name="placement.scatter",
    unit="rad",
    physics="every seating is tilted at random, standard deviation = value about each level axis",
    source="IEEE Std 1293, repeatability of mounting in the multiposition test",
    plausible=1e-4,
    columns=columns,
    separate_by="the positions again, each seated several times: the seating changes, the sensor does not",
    is_scatter=True,
)
