"""Tilt of one face of the cube: with it up, everything is seen turned, at rest and in turns.

Coefficient x_up.y is the component of the up vector along y with the cube on its face x_up. Half of what the
two faces of a pair have in common is parallelism. Plausible: 1e-3 rad, 0.4 mm on 400 mm.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation, rotation_columns
from procedures.frames import AXES, FACES, cross_axes, face_normal

KEYS = tuple(f"{face}.{AXES[k]}" for face in FACES for k in cross_axes(face))


def columns(excitation: Excitation) -> list[Columns]:
    """Return the tilts of the twelve components."""
    rotation = face_rotations(excitation)
    accel, gyro = rotation_columns(excitation, rotation)
    return [Columns(KEYS, accel=accel, gyro=gyro, rotation=rotation)]


def face_rotations(excitation: Excitation) -> FloatArray:
    """Return the rotation vector (n, 3, 12), IMU axes, of a unit of every face's tilt, as `face_rotation`."""
    rotation_b = np.zeros((len(excitation.steps), 3, len(KEYS)))
    for number, step in enumerate(excitation.steps):
        if step.face:
            first = 2 * FACES.index(step.face)
            for i, k in enumerate(cross_axes(step.face)):
                rotation_b[number, :, first + i] = np.cross(face_normal(step.face), np.eye(3)[k])
    return excitation.C_sb @ rotation_b[excitation.step]


EFFECT = Effect(
    name="fixture.face_tilt",
    unit="rad",
    physics="up seen in the cube on a face = its normal + tilt",
    source="Yao, Hu, He 2018, tables 2 and 3",
    plausible=1e-3,
    columns=columns,
    separate_by="a certificate of the faces, or the IMU re-mounted by 90 deg in the cube",
    separate_by_certified="the IMU re-mounted by 90 deg in the cube",
    is_turn=True,
    is_held_at_prior=True,
    covered_by="fixture.parallelism",
    carried_with="cube",
)
