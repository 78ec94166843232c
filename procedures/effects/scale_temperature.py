"""Temperature coefficient of a scale factor: ``c (T - 25 degC) (E u + D)``.

It multiplies the whole output, bias included. Plausible: 100 ppm/K, of a servo magnet without compensation as of a
FOG: its source's mean wavelength goes by some 400 ppm/K where nothing holds it, the coil's length and index by 10
ppm/K.
"""

from dataclasses import replace

from procedures.arrays import FloatArray
from procedures.effects.effect import REFERENCE_C, Effect, Excitation, of_accelerometers, of_gyroscopes


def _per_ppm(excitation: Excitation) -> FloatArray:
    return 1e-6 * (excitation.temperature - REFERENCE_C)[:, None]


ACCELEROMETER = Effect(
    name="accelerometer.scale_temperature",
    unit="ppm/K",
    physics="1e-6 c (T - 25 degC) (E u + D)",
    source="IEEE Std 1293, temperature sensitivity of scale factor",
    plausible=100.0,
    columns=of_accelerometers(lambda seen: _per_ppm(seen) * seen.accel_output),
    separate_by="the faces up and down again at a second temperature, in another order",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_temperature",
    source="IEEE Std 952, temperature sensitivity of scale factor",
    columns=of_gyroscopes(lambda seen: _per_ppm(seen) * seen.gyro_output),
    separate_by="the same turns again at a second temperature, or a rate table in a chamber",
)
