"""Asymmetry of the accelerometers' scale factor: ``a |u| / 2``, a = (k+ - k-) / k.

On a cube's faces |u| = u^2: it is one with K2 there. Plausible: 100 ppm, as of an analogue servo loop whose
digitiser has two references.
"""

from procedures.effects.effect import Columns, Effect, Seen, per_axis
from procedures.frames import AXES


def columns(seen: Seen) -> list[Columns]:
    """Return |u| / 2 per sensor [g per ppm]."""
    return [Columns(AXES, accel=per_axis(0.5e-6 * abs(seen.f)))]


EFFECT = Effect(
    name="accelerometer.scale_asymmetry",
    unit="ppm",
    physics="1e-6 a |u| / 2, a = (k+ - k-) / k",
    source="IEEE Std 1293, scale-factor asymmetry",
    plausible=100.0,
    columns=columns,
    separate_by="free positions between the faces, near 45 deg",
)
