"""A disturbance in one dwell: a shock, a footstep, a machine nearby.

It averages out of the counts' mean, or nearly: what shows it is their variance, over short stretches of the dwell,
and so it has no column. Plausible: 0.01 g, what a shock on the plate gives.
"""

from procedures.effects.effect import Effect

EFFECT = Effect(
    name="disturbance.dwell",
    unit="g",
    physics="specific force that comes and goes within a dwell",
    source="IEEE Std 1293, seismic noise of the test site",
    plausible=1e-2,
    separate_by="the same position again, with nobody near the surface plate",
)
