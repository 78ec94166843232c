"""Tilt of the slab: every vector of the world turns as the slab sees it.

Coefficients are the East and North components of the up vector seen from the slab. Plausible: 5e-3 rad, 0.3 deg.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.slab_attitudes import world_rotation_columns

ROTATION = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]])  # up leans east by a turn about north, as `slab_C_ln`


def columns(excitation: Excitation) -> list[Columns]:
    """Return the world turned about the slab's North and East."""
    accel, gyro, rotation = world_rotation_columns(excitation, ROTATION)
    return [Columns(("east", "north"), accel=accel, gyro=gyro, rotation=rotation)]


EFFECT = Effect(
    name="slab.tilt",
    unit="rad",
    physics="up in the surface plate's axes = (east, north, 1)",
    source="Yao, Hu, He 2018, section 2: positions in pairs turned by 180 deg",
    plausible=5e-3,
    columns=columns,
    separate_by="both positions of every face, turned by 180 deg",
    is_bench_parameter=True,
)
