"""Drift of the accelerometers' bias in time: ``d t``; the bias refers to t = 0 of the device's time.

Where temperature only rises, drift and temperature are one. Plausible: 100 ug/h, of a unit just switched on.
"""

from procedures.effects.effect import Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return the hours since t = 0 per sensor."""
    return [Columns(AXES, accel=per_axis(seen.t / 3600))]


EFFECT = Effect(
    name="accelerometer.bias_drift",
    unit="g/h",
    physics="d t / 3600 s",
    source="IEEE Std 1293, bias trend",
    plausible=1e-4,
    columns=columns,
    separate_by="a second campaign in another order, or a heating run up and down again",
)
