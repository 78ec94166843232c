"""Temperature coefficient of a scale factor: ``c (T - 25 degC) (E u + D)``.

It multiplies the whole output, bias included. Plausible: 100 ppm/K, of a servo magnet without compensation as of a
FOG: its source's mean wavelength goes by some 400 ppm/K where nothing holds it, the coil's length and index by 10
ppm/K.
"""

from dataclasses import replace

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Excitation, per_axis
from procedures.frames import AXES


def accelerometer_columns(excitation: Excitation) -> list[Columns]:
    """Return temperature beyond the reference times the output, per sensor [g per ppm/K]."""
    return [
        Columns(
            AXES, accel=per_axis(1e-6 * (excitation.temperature - REFERENCE_C)[:, None] * excitation.accel_output)
        )
    ]


def gyroscope_columns(excitation: Excitation) -> list[Columns]:
    """Return temperature beyond the reference times the output, per sensor [deg/s per ppm/K]."""
    return [
        Columns(
            AXES, gyro=per_axis(1e-6 * (excitation.temperature - REFERENCE_C)[:, None] * excitation.gyro_output)
        )
    ]


ACCELEROMETER = Effect(
    name="accelerometer.scale_temperature",
    unit="ppm/K",
    physics="1e-6 c (T - 25 degC) (E u + D)",
    source="IEEE Std 1293, temperature sensitivity of scale factor",
    plausible=100.0,
    columns=accelerometer_columns,
    separate_by="the faces up and down again at a second temperature, in another order",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_temperature",
    source="IEEE Std 952, temperature sensitivity of scale factor",
    columns=gyroscope_columns,
    separate_by="the same turns again at a second temperature, or a rate table in a chamber",
)
