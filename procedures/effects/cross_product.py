"""Cross products of the accelerometers: ``K u_i u_j``, i and j two different axes.

Zero on every face of a cube, where only one axis sees gravity: its columns are built at nominal attitude,
since on fitted ones they would be copies of the faces' tilts. Plausible: 20 ug/g^2, a fifth of K2: a pendulum's
cross terms come through its deflection, which is small against its own nonlinearity.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.frames import AXES

PAIRS = ((0, 1), (0, 2), (1, 2))
KEYS = tuple(sensor + AXES[i] + AXES[j] for sensor in AXES for i, j in PAIRS)  # xyz: sensor x, u_y u_z


def columns(excitation: Excitation) -> list[Columns]:
    """Return u_i u_j per sensor and pair."""
    products = np.stack([excitation.f[:, i] * excitation.f[:, j] for i, j in PAIRS], axis=1)
    accel: FloatArray = (np.eye(3)[None, :, :, None] * products[:, None, None, :]).reshape(len(products), 3, 9)
    return [Columns(KEYS, accel=accel)]


EFFECT = Effect(
    name="accelerometer.cross_product",
    unit="g/g^2",
    physics="K u_i u_j, i != j",
    source="IEEE Std 1293, model equation: cross-coupling coefficients K_ip, K_io, K_po",
    plausible=2e-5,
    columns=columns,
    separate_by="free positions near 45 deg about each axis",
)
