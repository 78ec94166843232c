"""Temperature coefficient of the accelerometers' scale factor: ``c (T - 25 degC) (E u + D)``.

It multiplies the whole output, bias included. Plausible: 100 ppm/K, of a servo magnet without compensation.
"""

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return temperature beyond the reference times the output, per sensor [g per ppm/K]."""
    return [Columns(AXES, accel=per_axis(1e-6 * (seen.temperature - REFERENCE_C)[:, None] * seen.accel_output))]


EFFECT = Effect(
    name="accelerometer.scale_temperature",
    unit="ppm/K",
    physics="1e-6 c (T - 25 degC) (E u + D)",
    source="IEEE Std 1293, temperature sensitivity of scale factor",
    plausible=100.0,
    columns=columns,
    separate_by="the faces up and down again at a second temperature, in another order",
)
