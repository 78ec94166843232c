"""Asymmetry of the gyroscopes' scale factor: ``a |u| / 2``, a = (k+ - k-) / k.

Turns + and - at equal speeds leave it alone; at different speeds it is one with an even nonlinearity. Plausible:
100 ppm.
"""

from procedures.effects.effect import Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return |u| / 2 per sensor [deg/s per ppm]."""
    return [Columns(AXES, gyro=per_axis(0.5e-6 * abs(seen.omega)))]


EFFECT = Effect(
    name="gyroscope.scale_asymmetry",
    unit="ppm",
    physics="1e-6 a |u| / 2, a = (k+ - k-) / k",
    source="IEEE Std 952, scale-factor asymmetry",
    plausible=100.0,
    columns=columns,
    separate_by="turns at two speeds in each direction, or a rate table",
)
