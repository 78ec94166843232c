"""The device's clock is fast: its sample lasts ``dt / (1 + 1e-6 value)`` of true seconds.

Counts per stated second fall by that much, of the whole output E u + D. The accelerometers' scale factor takes all
of it, and a closed turn or a move is the same angle by any clock (what is left of it there is a millionth of
Earth rate and bias), so the evidence proper is elsewhere: reference time ``utc_s`` and the mean period. Plausible:
100 ppm, a crystal without compensation.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation


def columns(excitation: Excitation) -> list[Columns]:
    """Return the output at rest and on a rate table less a millionth [g, deg/s per ppm]."""
    moved = np.array([step.kind in {"turn", "move"} for step in excitation.steps])[excitation.step]
    gyro = np.where(moved[:, None], 0.0, -1e-6 * excitation.gyro_output)
    return [Columns(("value",), accel=-1e-6 * excitation.accel_output[:, :, None], gyro=gyro[:, :, None])]


EFFECT = Effect(
    name="clock.rate",
    unit="ppm",
    physics="a sample lasts dt / (1 + 1e-6 value)",
    source="IEEE Std 1139, fractional frequency",
    plausible=100.0,
    columns=columns,
    separate_by="reference time (utc_s) beside the counts",
    multiplies_output=True,
)
