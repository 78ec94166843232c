"""Drift of the gyroscopes' bias in time: ``d t``; the bias refers to t = 0 of the device's time.

Where temperature only rises, drift and temperature are one. Plausible: 0.5 deg/h/h, of a unit just switched on.
"""

from procedures.effects.effect import Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return the hours since t = 0 per sensor [deg/s per deg/h/h]."""
    return [Columns(AXES, gyro=per_axis(seen.t / 3600 / 3600))]


EFFECT = Effect(
    name="gyroscope.bias_drift",
    unit="deg/h/h",
    physics="d t / 3600 s",
    source="IEEE Std 952, drift rate ramp",
    plausible=0.5,
    columns=columns,
    separate_by="a second campaign in another order, or a heating run up and down again",
)
