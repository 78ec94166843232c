"""One seating off: in one dwell the cube stands turned by a small rotation, dirt or a chip under it.

The rotation vector is in the cube's axes and turns every vector as the cube sees it. Where faces are free, a
seating and that of the position on the same face cannot be separated. Plausible: 5e-4 rad, 0.2 mm on 400 mm.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation, rotation_columns
from procedures.frames import AXES


def columns(excitation: Excitation) -> list[Columns]:
    """Return each dwell in a position turned about the cube's axes; ``where`` names position and file."""
    several = len({step.campaign for step in excitation.steps}) > 1
    turned = (*rotation_columns(excitation, excitation.C_sb), excitation.C_sb)
    found = list[Columns]()
    for number, step in enumerate(excitation.steps):
        if step.position and step.kind != "turn":
            here = excitation.step == number
            accel, gyro, rotation = (np.where(here[:, None, None], each, 0.0) for each in turned)
            where: dict[str, object] = {"position": step.position, "file": step.name}
            if several:  # whose files may share their names
                where["campaign"] = step.campaign + 1
            found.append(Columns(AXES, accel=accel, gyro=gyro, rotation=rotation, where=where))
    return found


EFFECT = Effect(
    name="placement.dwell",
    unit="rad",
    physics="rotation(x, y, z) of every vector as seen in the cube, in one dwell",
    source="Yao, Hu, He 2018, section 2: the cube seated on its face",
    plausible=5e-4,
    columns=columns,
    separate_by="the same position again, with plate and face wiped",
    is_turn=True,
)
