"""Asymmetry of a scale factor: ``a |u| / 2``, a = (k+ - k-) / k.

On a cube's faces |u| = u^2: of the accelerometers it is one with K2 there. Turns + and - at equal speeds leave
that of the gyroscopes alone; at different speeds it is one with an even nonlinearity. Plausible: 100 ppm, as of an
analogue servo loop whose digitiser has two references.
"""

from dataclasses import replace

from procedures.effects.effect import Effect, of_accelerometers, of_gyroscopes

ACCELEROMETER = Effect(
    name="accelerometer.scale_asymmetry",
    unit="ppm",
    physics="1e-6 a |u| / 2, a = (k+ - k-) / k",
    source="IEEE Std 1293, scale-factor asymmetry",
    plausible=100.0,
    columns=of_accelerometers(lambda seen: 0.5e-6 * abs(seen.f)),
    separate_by="free positions between the faces, near 45 deg",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.scale_asymmetry",
    source="IEEE Std 952, scale-factor asymmetry",
    columns=of_gyroscopes(lambda seen: 0.5e-6 * abs(seen.omega)),
    separate_by="turns at two speeds in each direction, or a rate table",
)
