"""Odd nonlinearity of the gyroscopes' scale factor: ``c u |u|``, or cubic, ``c u^3``.

Turns at one speed put it into the scale factor. The cubic is also the first term of the Sagnac sine: one alias
group. Plausible: 100 ppm/(deg/s), or 3 ppm/(deg/s)^2 as of an open loop that reaches 90 deg of phase at 300
deg/s.
"""

from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.frames import AXES

CUBIC_PLAUSIBLE = 3.0  # ppm/(deg/s)^2


def columns(excitation: Excitation) -> list[Columns]:
    """Return u |u| per sensor [deg/s per ppm/(deg/s)], and u^3 [deg/s per ppm/(deg/s)^2]."""
    u = excitation.omega
    return [
        Columns(AXES, gyro=per_axis(1e-6 * u * abs(u)), shape="u |u|"),
        Columns(
            AXES, gyro=per_axis(1e-6 * u**3), shape="u^3", unit="ppm/(deg/s)^2", plausible=(CUBIC_PLAUSIBLE,) * 3
        ),
    ]


EFFECT = Effect(
    name="gyroscope.scale_nonlinearity",
    unit="ppm/(deg/s)",
    physics="1e-6 c u |u|, or 1e-6 c u^3",
    source="IEEE Std 952, scale-factor nonlinearity",
    plausible=100.0,
    columns=columns,
    separate_by="turns at three speeds in each direction or a rate table; from a Sagnac sine (sin(s u) / s) only "
    "rates at which s u is near 1",
)
