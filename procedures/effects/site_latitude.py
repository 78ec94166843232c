"""The bench lies further north than stated: the Earth's rate dips by another angle.

Seen by the gyroscopes alone: gravity is stated on its own. Omega = W (0, cos L, sin L) in East-North-Up; its
change with L, W (0, -sin L, cos L), is a small rotation about East. Plausible: 0.02 rad, 1 deg.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.slab_attitudes import world_rotation_columns


def columns(excitation: Excitation) -> list[Columns]:
    """Return Earth rate turned about East [deg/s per rad], in turns too."""
    _, gyro, rotation = world_rotation_columns(excitation, np.array([[1.0], [0.0], [0.0]]))
    return [Columns(("value",), gyro=gyro, rotation=rotation)]


EFFECT = Effect(
    name="site.latitude",
    unit="rad",
    physics="latitude + value in the Earth's rate W (0, cos L, sin L)",
    source="IEEE Std 952, Earth rate as input in the multiposition test",
    plausible=0.02,
    columns=columns,
    separate_by="the latitude of the bench from a map or a receiver, in campaign.toml",
)
