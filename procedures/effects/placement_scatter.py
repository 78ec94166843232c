"""Seats scatter: in every dwell and turn the IMU in the cube, or the cube on the slab, leans by a draw of its own.

One variance for both level axes, fitted. A turn then goes about another axis of the IMU. Plausible: 1e-4 rad, 0.04
mm on 400 mm.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation, rotation_columns
from procedures.frames import AXES, cross_axes


def columns(excitation: Excitation) -> list[Columns]:
    """Return each dwell and turn tilted about the two level axes of the cube [g and deg/s per rad]."""
    names, parts = list[str](), list[np.ndarray]()
    for number, step in enumerate(excitation.steps):
        if step.position and step.kind in {"dwell", "turn"}:
            here = (excitation.step == number)[:, None]
            for axis in cross_axes(step.face):
                parts.append(np.where(here, excitation.C_sb[:, :, axis], 0.0))
                names.append(f"{step.campaign + 1}.{step.name}.{AXES[axis]}")
    if not parts:
        return []
    accel, gyro = rotation_columns(excitation, np.stack(parts, axis=2))
    return [Columns(tuple(names), accel=accel, gyro=gyro)]


EFFECT = Effect(
    name="placement.scatter",
    unit="rad",
    physics="every seat is tilted by a draw of 1 sigma = value about each level axis",
    source="IEEE Std 1293, repeatability of mounting in the multiposition test",
    plausible=1e-4,
    columns=columns,
    separate_by="the positions again, each seated several times: a seat changes, the sensor does not",
    is_scatter=True,
)
