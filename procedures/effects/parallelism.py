"""Parallelism of opposite faces: the sum of their tilts, half on each.

Coefficient x.y is the sum of x_up.y and x_down.y. Per axis, the two other pairs' along it are one with the bias
and K2. Plausible: 1e-3 rad, 0.4 mm on 400 mm.
"""

from procedures.effects.effect import Columns, Effect, Excitation, rotation_columns
from procedures.effects.face_tilt import face_rotations
from procedures.frames import AXES, cross_axes

KEYS = tuple(f"{axis}.{AXES[k]}" for axis in AXES for k in cross_axes(f"{axis}_up"))


def columns(excitation: Excitation) -> list[Columns]:
    """Return both faces of a pair tilted by a half each."""
    faces = face_rotations(excitation)
    pairs = faces.reshape(len(faces), 3, 3, 2, 2)  # node, vector, pair, up and down, component
    rotation = pairs.sum(axis=3).reshape(len(faces), 3, 6) / 2
    accel, gyro = rotation_columns(excitation, rotation)
    return [Columns(KEYS, accel=accel, gyro=gyro, rotation=rotation)]


EFFECT = Effect(
    name="fixture.parallelism",
    unit="rad",
    physics="up tilts of opposite faces = p/2 each",
    source="Yao, Hu, He 2018, tables 2 and 3, items t8, t9, t10",
    plausible=1e-3,
    columns=columns,
    separate_by="a certificate of the faces, or the IMU re-mounted by 90 deg in the cube",
    separate_by_certified="the IMU re-mounted by 90 deg in the cube",
    is_turn=True,
    is_bench_parameter=True,
    is_held_at_prior=True,
)
