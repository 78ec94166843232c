"""Scale factor that settles since power-on: ``1e-6 c exp(-t / tau)`` times ``E u + D``, t since the first sample.

The wavelength of a FOG's source settles after power-on as its own junction and its cooler do, and the Sagnac phase
goes with 1 / wavelength; an accelerometer's torquer magnet and pendulum come to their temperature by their own
heat. No thermometer of the case needs to see either. One time constant for the triad, fitted; of one far longer
than what was recorded it is a straight line, a scale factor that ages. c is what is left of it when a recording
begins, since when the power was on nobody records. It shows where the input of a sensor changes: where it stands,
a bias does the same. Plausible: 300 ppm, a source of 400 ppm/K without a cooler that warms by a kelvin.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.effects.settling import since_begun, ways_to_settle
from procedures.effects.time_constant import with_nonlinear
from procedures.frames import AXES
from procedures.units import PPM_PER_ONE

PLAUSIBLE = 300.0  # ppm
MIN_CHANGE = 0.5  # of the largest output of a sensor, by which its output must change


def settling(seen: Excitation, output: FloatArray, tau_s: float) -> FloatArray:
    """Return exp(-t / tau) times a triad's output (n, 3), in its unit per ppm; nought where that never changes."""
    changes = np.ptp(output, axis=0) > MIN_CHANGE * np.max(np.abs(output), axis=0)
    fading: FloatArray = np.exp(-since_begun(seen) / tau_s)[:, None] * output / PPM_PER_ONE
    return np.where(changes, fading, 0.0)


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the columns at a way's time constant [g per ppm], and a column for that."""
    value = settling(seen, seen.accel_output, way.tau_s)
    return with_nonlinear(replace(way, coefficients=AXES, accel=per_axis(value)), (PLAUSIBLE,) * 3)


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the columns at a way's time constant [deg/s per ppm], and a column for that."""
    value = settling(seen, seen.gyro_output, way.tau_s)
    return with_nonlinear(replace(way, coefficients=AXES, gyro=per_axis(value)), (PLAUSIBLE,) * 3)


ACCELEROMETER = Effect(
    name="accelerometer.scale_settling",
    unit="ppm",
    physics="1e-6 c exp(-t / tau) (E u + D), t since the recording began",
    source="IEEE Std 1293, warm-up time and scale factor stability; torquer magnet and pendulum warm up",
    plausible=PLAUSIBLE,
    columns=lambda seen: ways_to_settle(accelerometer_at, seen),
    separate_by="the campaign once more, in another order, when the unit has been on for an hour",
    at=accelerometer_at,
    driver="time",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_settling",
    source="IEEE Std 952, warm-up time and scale factor stability; the source's wavelength after power-on",
    columns=lambda seen: ways_to_settle(gyroscope_at, seen),
    at=gyroscope_at,
)
