"""Scale factor that goes with a temperature that nobody records: ``c1 (T_s - 25 degC) + ...`` times ``E u + D``.

``tau dT_s/dt = T - T_s``: a servo's magnet and a coil follow the thermometer, or a part of them does, by heat
conduction. One time constant for the triad, fitted. It shows where an input stands while temperature moves: faces
up and down, turns, or a rate table whose points have a time. Plausible: as a scale factor's
temperature coefficient.
"""

from dataclasses import replace

from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.scale_temperature import RANGE
from procedures.effects.temperature_lag import first_ways, lagged_powers, lagging
from procedures.units import PPM_PER_ONE


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial at a way's time constant times the output [g per ppm/K^n], and a column for that."""
    return lagging(way, RANGE, accel=lagged_powers(seen, way) / PPM_PER_ONE * seen.accel_output[:, :, None])


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial at a way's time constant times the output [deg/s per ppm/K^n], a column for that."""
    return lagging(way, RANGE, gyro=lagged_powers(seen, way) / PPM_PER_ONE * seen.gyro_output[:, :, None])


ACCELEROMETER = Effect(
    name="accelerometer.scale_temperature_lag",
    unit="ppm/K",
    physics="1e-6 (c1 (T_s - 25 degC) + c2 (T_s - 25 degC)^2 + ...) (E u + D), tau dT_s/dt = T - T_s",
    source="IEEE Std 1293, temperature sensitivity of scale factor; heat conduction, first order",
    plausible=RANGE,
    columns=lambda seen: [accelerometer_at(seen, way) for way in first_ways(seen)],
    separate_by="faces up and down in turn while it warms and cools, and again at rest in temperature",
    at=accelerometer_at,
    driver="temperature",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_temperature_lag",
    source="IEEE Std 952, temperature sensitivity of scale factor; heat conduction, first order",
    columns=lambda seen: [gyroscope_at(seen, way) for way in first_ways(seen)],
    separate_by="turns or a rate table while it warms and cools, and again at rest in temperature",
    at=gyroscope_at,
)
