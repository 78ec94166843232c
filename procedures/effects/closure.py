"""Turns close looser than stated: each comes back to where it began but for a draw of its own, a fitted variance.

A turn about the slab's normal n adds its angle along n, as the gyroscopes see it. Plausible: twice what is stated.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.slab_attitudes import slab_C_il

TIMES_STATED = 2.0


def columns(excitation: Excitation) -> list[Columns]:
    """Return a degree more turned in each turn [deg/s per deg], spread evenly over the turn, and at its end."""
    names, parts, ends, plausible = list[str](), list[FloatArray](), list[FloatArray](), list[float]()
    up = slab_C_il(excitation)[:, :, 2]
    for number, step in enumerate(excitation.steps):
        nodes = excitation.step == number
        if step.kind == "turn" and step.stated_std > 0 and nodes.sum() > 1:
            seconds = float(np.gradient(excitation.rest_s[nodes]).sum())
            parts.append(np.where(nodes[:, None], up / seconds, 0.0))
            last = np.arange(len(nodes)) == np.flatnonzero(nodes)[-1]
            ends.append(np.where(last[:, None], -np.radians(up), 0.0))
            names.append(f"{step.campaign + 1}.{step.name}")
            plausible.append(TIMES_STATED * float(np.degrees(step.stated_std)))
    if not parts:
        return []
    gyro = excitation.E_gyro @ np.stack(parts, axis=2)
    return [Columns(tuple(names), gyro=gyro, rotation=np.stack(ends, axis=2), plausible=tuple(plausible))]


EFFECT = Effect(
    name="procedure.closure",
    unit="deg",
    physics="every rotation has a random closure error, standard deviation = value about the plate's normal",
    source="Yao, Hu, He 2018, section 2: whole turns from a mark back to it",
    plausible=0.04,
    columns=columns,
    separate_by="the six rotations again with three times the revolutions: a closure error stays, an error of the "
    "scale factor grows with the angle",
    is_scatter=True,
    stated_share=1 / TIMES_STATED,
)
