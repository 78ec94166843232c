"""Temperature coefficients of a scale factor: ``(c1 (T - 25 degC) + c2 (T - 25 degC)^2 + ...) (E u + D)``.

It multiplies the whole output, bias included; the order is found from the data, for each sensor. Plausible: 100
ppm/K, of a servo magnet without compensation as of a FOG: its source's mean wavelength goes by some 400 ppm/K
where nothing holds it, the coil's length and index by 10 ppm/K.
"""

from dataclasses import replace

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Excitation
from procedures.effects.temperature_polynomial import FIRST_ORDERS, names, plausible, powers
from procedures.units import PPM_PER_ONE

RANGE = 100.0  # ppm/K


def _without_output(seen: Excitation, way: Columns) -> Columns:
    value = powers(seen.temperature - REFERENCE_C, way.orders) / PPM_PER_ONE
    return Columns(names(way.orders), value, orders=way.orders, plausible=plausible(RANGE, way.orders))


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial of a way's orders times the output [g per ppm/K^n]."""
    found = _without_output(seen, way)
    assert found.accel is not None
    return replace(found, accel=found.accel * seen.accel_output[:, :, None])


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial of a way's orders times the output [deg/s per ppm/K^n]."""
    found = _without_output(seen, way)
    assert found.accel is not None
    return replace(found, accel=None, gyro=found.accel * seen.gyro_output[:, :, None])


ACCELEROMETER = Effect(
    name="accelerometer.scale_temperature",
    unit="ppm/K",
    physics="1e-6 (c1 (T - 25 degC) + c2 (T - 25 degC)^2 + ...) (E u + D)",
    source="IEEE Std 1293, temperature sensitivity of scale factor",
    plausible=RANGE,
    columns=lambda seen: [accelerometer_at(seen, Columns((), orders=(n, n, n))) for n in FIRST_ORDERS],
    separate_by="the faces up and down again at a second temperature, in another order",
    at=accelerometer_at,
    driver="temperature",
    multiplies_output=True,
    same_at_rest="accelerometer.bias_temperature",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_temperature",
    source="IEEE Std 952, temperature sensitivity of scale factor",
    columns=lambda seen: [gyroscope_at(seen, Columns((), orders=(n, n, n))) for n in FIRST_ORDERS],
    separate_by="the same turns again at a second temperature, or a rate table in a chamber",
    at=gyroscope_at,
    same_at_rest="gyroscope.bias_temperature",
)
