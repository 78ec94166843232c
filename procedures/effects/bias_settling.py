"""Bias that settles since power-on: ``b exp(-t / tau)``, t since the first sample.

Electronics, servo loop and source come to their temperature by their own heat after power-on, and a bias with
them: the warm-up time of a data sheet. A thermometer of the case need not see it. One time constant for the triad,
fitted; of one far longer than what was recorded it is a drift. b is what is left of it when a recording begins,
since when the power was on nobody records. Plausible: 200 ug and 1 deg/h, as of units that are ten times as stable
when warm.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.effects.settling import since_begun, ways_to_settle
from procedures.effects.time_constant import with_nonlinear
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S

PLAUSIBLE_G = 2e-4
PLAUSIBLE_DEG_H = 1.0


def _fading(seen: Excitation, way: Columns) -> FloatArray:
    fading: FloatArray = np.exp(-since_begun(seen) / way.tau_s)
    return fading


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the columns at a way's time constant [g per g], and a column for that."""
    found = replace(way, coefficients=AXES, accel=per_axis(_fading(seen, way)))
    return with_nonlinear(found, (PLAUSIBLE_G,) * 3)


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the columns at a way's time constant [deg/s per deg/h], and a column for that."""
    found = replace(way, coefficients=AXES, gyro=per_axis(_fading(seen, way) / DEG_H_PER_DEG_S))
    return with_nonlinear(found, (PLAUSIBLE_DEG_H,) * 3)


ACCELEROMETER = Effect(
    name="accelerometer.bias_settling",
    unit="g",
    physics="b exp(-t / tau), t since the recording began",
    source="IEEE Std 1293, warm-up time and bias stability",
    plausible=PLAUSIBLE_G,
    columns=lambda seen: ways_to_settle(accelerometer_at, seen),
    separate_by="the campaign once more, in another order, when the unit has been on for an hour",
    at=accelerometer_at,
    driver="time",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.bias_settling",
    unit="deg/h",
    source="IEEE Std 952, warm-up time and turn-on bias",
    plausible=PLAUSIBLE_DEG_H,
    columns=lambda seen: ways_to_settle(gyroscope_at, seen),
    at=gyroscope_at,
)
