"""Drift of a bias in time: ``d t``; the bias refers to t = 0 of the device's time.

Where temperature only rises, drift and temperature are one. Plausible, of a unit just switched on: 100 ug/h of the
accelerometers, 0.5 deg/h/h of the gyroscopes.
"""

from dataclasses import replace

from procedures.effects.effect import Effect, of_accelerometers, of_gyroscopes
from procedures.units import DEG_H_PER_DEG_S, S_PER_H

ACCELEROMETER = Effect(
    name="accelerometer.bias_drift",
    unit="g/h",
    physics="d t / 3600 s",
    source="IEEE Std 1293, bias trend",
    plausible=1e-4,
    columns=of_accelerometers(lambda seen: seen.t / S_PER_H),
    separate_by="a second campaign in another order, or a heating run up and down again",
    driver="time",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.bias_drift",
    unit="deg/h/h",
    source="IEEE Std 952, drift rate ramp",
    plausible=0.5,
    columns=of_gyroscopes(lambda seen: seen.t / S_PER_H / DEG_H_PER_DEG_S),
)
