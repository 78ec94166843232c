"""Hysteresis of a bias between warming and cooling: ``h d``, d = 1 while it grows warmer, -1 while it cools.

What mounting, adhesive and winding keep of the way they came. The direction turns where temperature has come back
by half a kelvin, from the turning point on. Of steady ramps it is the temperature's rate. Plausible: 100 ug and
0.5 deg/h, half of what opens between the two branches.
"""

from dataclasses import replace

from procedures.effects.effect import Effect, of_accelerometers, of_gyroscopes
from procedures.effects.temperature_history import warming
from procedures.units import DEG_H_PER_DEG_S

ACCELEROMETER = Effect(
    name="accelerometer.temperature_hysteresis",
    unit="g",
    physics="h d, d = 1 while it grows warmer, -1 while it cools",
    source="IEEE Std 1293, hysteresis of bias over temperature",
    plausible=1e-4,
    columns=of_accelerometers(warming),
    separate_by="a heating run up and down with ramps of different steepness and long plateaus",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.temperature_hysteresis",
    unit="deg/h",
    source="IEEE Std 952, hysteresis of bias over temperature",
    plausible=0.5,
    columns=of_gyroscopes(lambda seen: warming(seen) / DEG_H_PER_DEG_S),
)
