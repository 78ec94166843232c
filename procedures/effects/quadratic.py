"""Second-order nonlinearity of the accelerometers: each adds ``K2 u^2`` to its output.

On a cube's faces u is 0 or +-1 g, and K2 is one with the bias and the parallelism of the two other face pairs.
"""

from procedures.effects.effect import Effect, of_accelerometers

EFFECT = Effect(
    name="accelerometer.quadratic",
    unit="g/g^2",
    physics="K2 u^2",
    source="IEEE Std 1293, model equation: second-order nonlinearity K2",
    plausible=1e-4,
    columns=of_accelerometers(lambda seen: seen.f**2),
    # A group with the bench has the bench's name: here it is the asymmetry, which no face tells, however mounted.
    separate_by="free positions near 45 deg",
)
