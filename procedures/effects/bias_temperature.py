"""Temperature coefficients of a bias: ``c1 (T - 25 degC) + c2 (T - 25 degC)^2 + ...``.

The order is found from the data, for each sensor. Plausible: 100 ug/K of the accelerometers; 0.3 deg/h/K of the
gyroscopes, of a tactical FOG without compensation; a navigation one has a tenth of it.
"""

from dataclasses import replace

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Excitation
from procedures.effects.temperature_polynomial import FIRST_ORDERS, names, plausible, powers
from procedures.units import DEG_H_PER_DEG_S

ACCEL_RANGE, GYRO_RANGE = 1e-4, 0.3  # g/K, deg/h/K


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial of a way's orders [g per g/K^n]."""
    value = seen.temperature - REFERENCE_C
    return Columns(
        names(way.orders), accel=powers(value, way.orders), orders=way.orders,
        plausible=plausible(ACCEL_RANGE, way.orders),
    )  # fmt: skip


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return the polynomial of a way's orders [deg/s per deg/h/K^n]."""
    value = seen.temperature - REFERENCE_C
    return Columns(
        names(way.orders), gyro=powers(value, way.orders) / DEG_H_PER_DEG_S, orders=way.orders,
        plausible=plausible(GYRO_RANGE, way.orders),
    )  # fmt: skip


ACCELEROMETER = Effect(
    name="accelerometer.bias_temperature",
    unit="g/K",
    physics="c1 (T - 25 degC) + c2 (T - 25 degC)^2 + ...",
    source="IEEE Std 1293, temperature sensitivity of bias",
    plausible=ACCEL_RANGE,
    columns=lambda seen: [accelerometer_at(seen, Columns((), orders=(n, n, n))) for n in FIRST_ORDERS],
    separate_by="a heating run up and down again, or a second campaign in another order",
    at=accelerometer_at,
    driver="temperature",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.bias_temperature",
    unit="deg/h/K",
    source="IEEE Std 952, temperature sensitivity of bias",
    plausible=GYRO_RANGE,
    columns=lambda seen: [gyroscope_at(seen, Columns((), orders=(n, n, n))) for n in FIRST_ORDERS],
    at=gyroscope_at,
)
