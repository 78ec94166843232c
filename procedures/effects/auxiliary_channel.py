"""An auxiliary channel acts on the sensors: ``c aux``; the bias holds where the channel is zero.

Slow channels have gaps: in between it is linear. A channel that a step does not have at all is not known, and then
nothing is said of it. Plausible: 100 ug and 1 deg/h by one standard deviation of what the channel did.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.units import DEG_H_PER_DEG_S

KEYS = ("ax", "ay", "az", "gx", "gy", "gz")
ACCEL_RANGE, GYRO_RANGE = 1e-4, 1.0  # g, deg/h by one standard deviation of the channel


def columns(excitation: Excitation) -> list[Columns]:
    """Return each channel per sensor [g per g/unit, deg/s per deg/h/unit]; ``where`` names it."""
    found = list[Columns]()
    for name, known in excitation.auxiliary.items():
        value = without_gaps(excitation, known)
        spread = float(np.std(value))
        if not spread > 0:
            continue
        acts = value[:, None, None]
        accel, gyro = acts * np.eye(3, 6), acts / DEG_H_PER_DEG_S * np.eye(3, 6, 3)
        ranges = (ACCEL_RANGE / spread,) * 3 + (GYRO_RANGE / spread,) * 3
        found.append(Columns(KEYS, accel=accel, gyro=gyro, where={"channel": name}, plausible=ranges))
    return found


def without_gaps(excitation: Excitation, values: FloatArray) -> FloatArray:
    """Return a channel ``values`` (n,), in its unit, with what is missing within a step interpolated."""
    filled = values.copy()
    for number in range(len(excitation.steps)):
        nodes = np.flatnonzero(excitation.step == number)
        known = nodes[np.isfinite(values[nodes])]
        if len(known):
            filled[nodes] = np.interp(excitation.t[nodes], excitation.t[known], values[known])
    return filled


EFFECT = Effect(
    name="auxiliary.channel",
    unit="ax..az: g/unit, gx..gz: deg/h/unit",
    physics="c aux",
    source="IEEE Std 952 and 1293, environmental sensitivities of the model equations",
    plausible=1.0,
    columns=columns,
    separate_by="the channel changed on purpose while the cube rests",
    driver="channel",
    carried_with="unit",
)
