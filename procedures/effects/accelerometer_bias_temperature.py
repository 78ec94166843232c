"""Temperature coefficient of the accelerometers' bias: ``c (T - 25 degC)``."""

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return the temperature beyond the reference per sensor."""
    return [Columns(AXES, accel=per_axis(seen.temperature - REFERENCE_C))]


EFFECT = Effect(
    name="accelerometer.bias_temperature",
    unit="g/K",
    physics="c (T - 25 degC)",
    source="IEEE Std 1293, temperature sensitivity of bias",
    plausible=1e-4,
    columns=columns,
    separate_by="a heating run up and down again, or a second campaign in another order",
)
