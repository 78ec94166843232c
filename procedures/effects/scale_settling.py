"""Scale factor that settles since power-on: ``1e-6 c exp(-t / tau)`` times ``E u + D``, t since the first sample.

The wavelength of a FOG's source settles after power-on as its own junction and its cooler do, and the Sagnac phase
goes with 1 / wavelength; an accelerometer's torquer magnet and pendulum come to their temperature by their own
heat. No thermometer of the case needs to see either. One time constant for the triad, fitted; of one far longer
than what was recorded it is a straight line, a scale factor that ages. c is what is left of it when a recording
begins, since when the power was on nobody records. It shows where the input of a sensor changes: where it stands,
a bias does the same. Plausible: 300 ppm, a source of 400 ppm/K without a cooler that warms by a kelvin.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import TAU, Columns, Effect, Excitation, per_axis
from procedures.effects.time_constant import search, with_nonlinear
from procedures.frames import AXES
from procedures.units import PPM_PER_ONE

SHORTEST_S = 30.0  # s, to begin with
PLAUSIBLE = 300.0  # ppm
MIN_CHANGE = 0.5  # of the largest output of a sensor, by which its output must change


def settling(seen: Excitation, output: FloatArray, tau_s: float) -> FloatArray:
    """Return exp(-t / tau) times a triad's output (n, 3), in its unit per ppm; nought where that never changes."""
    changes = np.ptp(output, axis=0) > MIN_CHANGE * np.max(np.abs(output), axis=0)
    fading: FloatArray = np.exp(-_since_begun(seen) / tau_s)[:, None] * output / PPM_PER_ONE
    return np.where(changes, fading, 0.0)


def _since_begun(seen: Excitation) -> FloatArray:
    """Return the time (n,) [s] since each history's first node; nan where no time is known."""
    history = seen.histories[seen.step]
    begun = np.array([np.min(seen.t[history == one], initial=np.inf) for one in range(int(history.max()) + 1)])
    found: FloatArray = seen.t - begun[history]
    return found


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the columns at a way's time constant [g per ppm], and a column for that."""
    value = settling(seen, seen.accel_output, way.tau_s)
    return with_nonlinear(replace(way, coefficients=AXES, accel=per_axis(value)), (PLAUSIBLE,) * 3)


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the columns at a way's time constant [deg/s per ppm], and a column for that."""
    value = settling(seen, seen.gyro_output, way.tau_s)
    return with_nonlinear(replace(way, coefficients=AXES, gyro=per_axis(value)), (PLAUSIBLE,) * 3)


def _ways(at: Callable[[Excitation, Columns], Columns], seen: Excitation) -> list[Columns]:
    """Return the time constants that a search begins with; none where no time is known."""
    since = _since_begun(seen)
    if not np.isfinite(since).all():
        return []
    return [at(seen, Columns((), nonlinear={TAU: tau})) for tau in search(SHORTEST_S, float(since.max()))]


ACCELEROMETER = Effect(
    name="accelerometer.scale_settling",
    unit="ppm",
    physics="1e-6 c exp(-t / tau) (E u + D), t since the recording began",
    source="IEEE Std 1293, warm-up time and scale factor stability; torquer magnet and pendulum warm up",
    plausible=PLAUSIBLE,
    columns=lambda seen: _ways(accelerometer_at, seen),
    separate_by="the campaign once more, in another order, when the unit has been on for an hour",
    at=accelerometer_at,
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_settling",
    source="IEEE Std 952, warm-up time and scale factor stability; the source's wavelength after power-on",
    columns=lambda seen: _ways(gyroscope_at, seen),
    at=gyroscope_at,
)
