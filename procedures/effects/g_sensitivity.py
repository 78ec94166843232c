"""g-sensitivity of the gyroscopes: specific force adds to the bias, ``G f``.

Its vertical part follows the magnetic field's where the field's horizontal part is small, and with the axis
vertical it is one with the Earth rate times a scale factor error (0.001 deg/h per 100 ppm).
"""

from procedures.effects.effect import MATRIX, Columns, Effect, matrix_columns
from procedures.units import DEG_H_PER_DEG_S

EFFECT = Effect(
    name="gyroscope.g_sensitivity",
    unit="deg/h/g",
    physics="G f",
    source="IEEE Std 952, model equation: acceleration-sensitive drift",
    plausible=3.0,
    columns=lambda seen: [Columns(MATRIX, gyro=matrix_columns(seen.f) / DEG_H_PER_DEG_S)],
    separate_by="the same positions with the magnetic field turned or shielded",
)
