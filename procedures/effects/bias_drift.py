"""Drift of a bias in time: ``d t``; the bias refers to t = 0 of the device's time.

Where temperature only rises, drift and temperature are one. Plausible, of a unit just switched on: 100 ug/h of the
accelerometers, 0.5 deg/h/h of the gyroscopes.
"""

from dataclasses import replace

from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S, S_PER_H


def accelerometer_columns(excitation: Excitation) -> list[Columns]:
    """Return the hours since t = 0 per sensor [g per g/h]."""
    return [Columns(AXES, accel=per_axis(excitation.t / S_PER_H))]


def gyroscope_columns(excitation: Excitation) -> list[Columns]:
    """Return the hours since t = 0 per sensor [deg/s per deg/h/h]."""
    return [Columns(AXES, gyro=per_axis(excitation.t / S_PER_H / DEG_H_PER_DEG_S))]


ACCELEROMETER = Effect(
    name="accelerometer.bias_drift",
    unit="g/h",
    physics="d t / 3600 s",
    source="IEEE Std 1293, bias trend",
    plausible=1e-4,
    columns=accelerometer_columns,
    separate_by="a second campaign in another order, or a heating run up and down again",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.bias_drift",
    unit="deg/h/h",
    source="IEEE Std 952, drift rate ramp",
    plausible=0.5,
    columns=gyroscope_columns,
)
