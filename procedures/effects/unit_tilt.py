"""The unit was tilted in the midst of a rest, and stays so: a nudge, a stand that gives way.

The specific force turns by a small rotation about the level axes from some moment on; what is along it stays. A
jump of the accelerometers' biases across gravity looks the same. Plausible: 0.01 rad, or as far as a rest wanders.
"""

from functools import partial

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.jump import Jumps, block_times, place_after, place_within, places, places_within
from procedures.frames import AXES


def columns(excitation: Excitation) -> Jumps:
    """Return a rotation (x, y, z) [g per rad] of the specific force at every place of a soak where it is known."""
    if not np.isfinite(excitation.f).all() or not any(step.kind == "soak" for step in excitation.steps):
        return Jumps([])
    turned = np.stack([np.cross(excitation.f, axis) for axis in np.eye(3)], axis=2)

    def tilted(where: dict[str, object], later: FloatArray) -> Columns:
        return Columns(AXES, where=where, accel=later[:, None, None] * turned)

    blocks = block_times(excitation)
    found = [(place_after(excitation, s, blocks), later) for s, later in places(excitation) if s.kind == "soak"]
    found += [
        (place_within(excitation, s, seconds, blocks), later)
        for s, seconds, later in places_within(excitation)
        if s.kind == "soak"
    ]
    return Jumps([partial(tilted, where, later) for where, later in found])


EFFECT = Effect(
    name="placement.tilt",
    unit="rad",
    physics="rotation(x, y, z) of the specific force, from a moment on",
    source="IEEE Std 1293, stability of the test pier",
    plausible=0.01,
    columns=columns,
    separate_by="the rest again, with nobody near the stand; at another attitude a bias is along gravity",
    may_hang_on_a_step=True,
    driver="time",
)
