"""The slab's North mark points east of true north: horizontal Earth rate comes from elsewhere.

Seen by the gyroscopes alone; a heading error of one step is one draw, this is common to all. Plausible: 0.02
rad, a slab aligned by compass.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.slab_attitudes import world_rotation_columns


def columns(excitation: Excitation) -> list[Columns]:
    """Return Earth rate turned about the vertical [deg/s per rad], in turns too."""
    _, gyro, rotation = world_rotation_columns(excitation, np.array([[0.0], [0.0], [1.0]]))
    return [Columns(("value",), gyro=gyro, rotation=rotation)]


EFFECT = Effect(
    name="site.azimuth",
    unit="rad",
    physics="the surface plate's North mark points east of true north: C_ln turns about the vertical",
    source="IEEE Std 952, Earth rate as input in the multiposition test",
    plausible=0.02,
    columns=columns,
    separate_by="a survey of the surface plate's North mark",
)
