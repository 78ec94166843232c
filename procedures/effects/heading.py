"""Headings of placements are set looser than stated: a turn about the vertical in each dwell, a fitted variance.

The gyroscopes see it by the Earth's horizontal rate, accelerometers by the tilt of the slab. Plausible: twice what
is stated.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.slab_attitudes import slab_C_il

TIMES_STATED = 2.0


def columns(excitation: Excitation) -> list[Columns]:
    """Return every dwell turned by a degree about the slab's normal [g and deg/s per deg]."""
    names, plausible = list[str](), list[float]()
    level, turned, about = list[FloatArray](), list[FloatArray](), list[FloatArray]()
    C_il = slab_C_il(excitation)
    earth = np.radians(np.cross(C_il[:, :, 2], excitation.omega))
    for number, step in enumerate(excitation.steps):
        nodes = excitation.step == number
        if step.kind == "dwell" and step.stated_std > 0:
            from_east, from_north = step.slab_tilt
            tilted = np.radians(C_il @ np.array([-from_north, from_east, 0.0]))
            level.append(np.where(nodes[:, None], tilted, 0.0))
            turned.append(np.where(nodes[:, None], earth, 0.0))
            about.append(np.where(nodes[:, None], np.radians(C_il[:, :, 2]), 0.0))
            names.append(f"{step.campaign + 1}.{step.name}")
            plausible.append(TIMES_STATED * float(np.degrees(step.stated_std)))
    if not names:
        return []
    accel, gyro, rotation = (np.stack(parts, axis=2) for parts in (level, turned, about))
    accel, gyro = excitation.E_accel @ accel, excitation.E_gyro @ gyro
    return [Columns(tuple(names), accel=accel, gyro=gyro, rotation=rotation, plausible=tuple(plausible))]


EFFECT = Effect(
    name="procedure.heading",
    unit="deg",
    physics="every placement is turned at random, standard deviation = value about the vertical",
    source="IEEE Std 952, alignment errors of the multiposition test",
    plausible=0.2,
    columns=columns,
    separate_by="the positions again, against a stop on the surface plate",
    is_scatter=True,
    stated_share=1 / TIMES_STATED,
)
