"""Third-order nonlinearity of the accelerometers: each adds ``K3 u^3`` to its output.

On a cube's faces u is 0 or +-1 g, where u^3 = u: K3 is one with the scale factor. Plausible: a pendulous
accelerometer's K3 is 1 to 50 ug/g^3.
"""

from procedures.effects.effect import Effect, of_accelerometers

EFFECT = Effect(
    name="accelerometer.cubic",
    unit="g/g^3",
    physics="K3 u^3",
    source="IEEE Std 1293, model equation: third-order nonlinearity K3",
    plausible=5e-5,
    columns=of_accelerometers(lambda seen: seen.f**3),
    separate_by="free positions between the faces, near 45 deg",
)
