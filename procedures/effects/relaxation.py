"""Relaxation of the accelerometers after a flip: ``A exp(-t / tau)``, t since the step began.

Flexure and suspension creep after the load on them changed. A is the same after every flip, or in proportion to
the change of specific force along the axis; each with a grid of tau, whose neighbours differ by less than data
of some sigmas can tell. The cube comes to rest before a step begins: A is what is left at its beginning.
Plausible: 100 ug.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.frames import AXES

TAUS_S = (3, 5, 8, 13, 20, 30, 50)
AT_REST = ("dwell", "rest")


def columns(excitation: Excitation) -> list[Columns]:
    """Return exp(-t / tau) per sensor at rests, and that times the change of f, unknown (nought) of the first."""
    rests = np.array([step.kind in AT_REST for step in excitation.steps])[excitation.step]
    if not rests.any():
        return []
    change = np.nan_to_num(excitation.change)
    found = list[Columns]()
    for tau in TAUS_S:
        fading = np.where(rests, np.exp(-excitation.rest_s / tau), 0.0)
        found.append(Columns(AXES, accel=per_axis(fading), shape=f"tau = {tau} s"))
        by_change = per_axis(fading[:, None] * change)
        found.append(Columns(AXES, accel=by_change, shape=f"tau = {tau} s, by the change of f", unit="g/g"))
    return found


EFFECT = Effect(
    name="accelerometer.relaxation",
    unit="g",
    physics="A exp(-t / tau) after a flip; A constant, or in proportion to the change of u",
    source="IEEE Std 1293, hysteresis and warm-up trend after tumbling",
    plausible=1e-4,
    columns=columns,
    separate_by="a long dwell after a flip, and one without a flip before it",
)
