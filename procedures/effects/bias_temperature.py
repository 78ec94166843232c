"""Temperature coefficient of a bias: ``c (T - 25 degC)``.

Plausible: 100 ug/K of the accelerometers; 0.3 deg/h/K of the gyroscopes, of a tactical FOG without compensation; a
navigation one has a tenth of it.
"""

from dataclasses import replace

from procedures.effects.effect import REFERENCE_C, Effect, of_accelerometers, of_gyroscopes
from procedures.units import DEG_H_PER_DEG_S

ACCELEROMETER = Effect(
    name="accelerometer.bias_temperature",
    unit="g/K",
    physics="c (T - 25 degC)",
    source="IEEE Std 1293, temperature sensitivity of bias",
    plausible=1e-4,
    columns=of_accelerometers(lambda seen: seen.temperature - REFERENCE_C),
    separate_by="a heating run up and down again, or a second campaign in another order",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.bias_temperature",
    unit="deg/h/K",
    source="IEEE Std 952, temperature sensitivity of bias",
    plausible=0.3,
    columns=of_gyroscopes(lambda seen: (seen.temperature - REFERENCE_C) / DEG_H_PER_DEG_S),
)
