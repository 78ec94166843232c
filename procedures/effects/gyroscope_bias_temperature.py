"""Temperature coefficient of the gyroscopes' bias: ``c (T - 25 degC)``.

Plausible: 0.3 deg/h/K, of a tactical FOG without compensation; a navigation one has a tenth of it.
"""

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return the temperature beyond the reference per sensor [deg/s per deg/h/K]."""
    return [Columns(AXES, gyro=per_axis((seen.temperature - REFERENCE_C) / 3600))]


EFFECT = Effect(
    name="gyroscope.bias_temperature",
    unit="deg/h/K",
    physics="c (T - 25 degC)",
    source="IEEE Std 952, temperature sensitivity of bias",
    plausible=0.3,
    columns=columns,
    separate_by="a heating run up and down again, or a second campaign in another order",
)
