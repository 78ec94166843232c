"""Bias that goes with a temperature that nobody records: ``c1 (T_s - 25 degC) + ...``, ``tau dT_s/dt = T - T_s``.

The sensor follows the thermometer, or a part of it does: beside a temperature coefficient it is what the coil, the
proof mass or a gradient lags behind. One time constant for the triad, fitted. A short one is a temperature
coefficient with one of the rate, ``T_s = T - tau dT/dt``. Plausible: as a bias' temperature coefficient.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.bias_temperature import ACCEL_RANGE, GYRO_RANGE
from procedures.effects.effect import REFERENCE_C, TAU, Columns, Effect, Excitation
from procedures.effects.temperature_history import recorded_s, sensor_temperature
from procedures.effects.temperature_polynomial import names, plausible, powers
from procedures.effects.time_constant import search, with_nonlinear
from procedures.units import DEG_H_PER_DEG_S

SHORTEST_S = 20.0  # s, to begin with: shorter ones show in the temperature's rate
FIRST_LAGGED_ORDERS = (1, 2, 3)  # with which a search begins


def lagging(
    way: Columns, most: float, *, accel: FloatArray | None = None, gyro: FloatArray | None = None
) -> Columns:
    """Return a polynomial of plausible size ``most``, and a column for the time constant.

    ``accel`` and ``gyro`` (n, 3, k) are its columns, in the unit of a triad's output by that of a coefficient.
    """
    found = Columns(names(way.orders), accel=accel, gyro=gyro, orders=way.orders, nonlinear=way.nonlinear)
    return with_nonlinear(found, plausible(most, way.orders))


def lagged_powers(seen: Excitation, way: Columns) -> FloatArray:
    """Return the powers (n, 3, k) [K^n] of the temperature that follows, from where the effect vanishes."""
    return powers(sensor_temperature(seen, way.tau_s) - REFERENCE_C, way.orders)


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial at a way's time constant [g per g/K^n], and a column for that."""
    return lagging(way, ACCEL_RANGE, accel=lagged_powers(seen, way))


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial at a way's time constant [deg/s per deg/h/K^n], and a column for that."""
    return lagging(way, GYRO_RANGE, gyro=lagged_powers(seen, way) / DEG_H_PER_DEG_S)


def first_ways(seen: Excitation) -> list[Columns]:
    """Return lines and parabolas with the time constants of a first search; none of an unknown temperature."""
    if not np.isfinite(seen.temperature).all():
        return []
    return [
        Columns((), orders=(order,) * 3, nonlinear={TAU: tau})
        for order in FIRST_LAGGED_ORDERS
        for tau in search(SHORTEST_S, recorded_s(seen))
    ]


ACCELEROMETER = Effect(
    name="accelerometer.temperature_lag",
    unit="g/K",
    physics="c1 (T_s - 25 degC) + c2 (T_s - 25 degC)^2 + ..., tau dT_s/dt = T - T_s",
    source="IEEE Std 1293, temperature sensitivity of bias; heat conduction, first order",
    plausible=ACCEL_RANGE,
    columns=lambda seen: [accelerometer_at(seen, way) for way in first_ways(seen)],
    separate_by="a heating run with ramps and long plateaus, up and down",
    at=accelerometer_at,
    driver="temperature",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.temperature_lag",
    unit="deg/h/K",
    source="IEEE Std 952, temperature sensitivity of bias; heat conduction, first order",
    plausible=GYRO_RANGE,
    columns=lambda seen: [gyroscope_at(seen, way) for way in first_ways(seen)],
    at=gyroscope_at,
)
