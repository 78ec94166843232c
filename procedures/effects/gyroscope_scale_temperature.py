"""Temperature coefficient of the gyroscopes' scale factor: ``c (T - 25 degC) (E u + D)``.

The source's mean wavelength goes by some 400 ppm/K where nothing holds it, the coil's length and index by 10
ppm/K. Plausible: 100 ppm/K. It multiplies the whole output, bias included.
"""

from procedures.effects.effect import REFERENCE_C, Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return temperature beyond the reference times the output, per sensor [deg/s per ppm/K]."""
    return [Columns(AXES, gyro=per_axis(1e-6 * (seen.temperature - REFERENCE_C)[:, None] * seen.gyro_output))]


EFFECT = Effect(
    name="gyroscope.scale_temperature",
    unit="ppm/K",
    physics="1e-6 c (T - 25 degC) (E u + D)",
    source="IEEE Std 952, temperature sensitivity of scale factor",
    plausible=100.0,
    columns=columns,
    separate_by="the same turns again at a second temperature, or a rate table in a chamber",
)
