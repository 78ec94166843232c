"""The faces of the cube: tilts of each, and of opposite ones together."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation, rotation_columns
from procedures.frames import AXES
from procedures.positions import FACES, cross_axes, face_normal

FACE_KEYS = tuple(f"{face}.{AXES[k]}" for face in FACES for k in cross_axes(face))
PAIR_KEYS = tuple(f"{axis}.{AXES[k]}" for axis in AXES for k in cross_axes(f"{axis}_up"))


def face_columns(excitation: Excitation) -> list[Columns]:
    """Return the tilts of the twelve components."""
    return _turned(excitation, FACE_KEYS, face_rotations(excitation))


def pair_columns(excitation: Excitation) -> list[Columns]:
    """Return both faces of a pair tilted by a half each."""
    faces = face_rotations(excitation)
    pairs = faces.reshape(len(faces), 3, 3, 2, 2)  # node, vector, pair, up and down, component
    return _turned(excitation, PAIR_KEYS, pairs.sum(axis=3).reshape(len(faces), 3, 6) / 2)


def _turned(excitation: Excitation, keys: tuple[str, ...], rotation: FloatArray) -> list[Columns]:
    accel, gyro = rotation_columns(excitation, rotation)
    return [Columns(keys, accel=accel, gyro=gyro, rotation=rotation)]


def face_rotations(excitation: Excitation) -> FloatArray:
    """Return the rotation vector (n, 3, 12), IMU axes, of a unit of every face's tilt, as `face_rotation`."""
    rotation_b = np.zeros((len(excitation.steps), 3, len(FACE_KEYS)))
    for number, step in enumerate(excitation.steps):
        if step.face:
            first = 2 * FACES.index(step.face)
            for i, k in enumerate(cross_axes(step.face)):
                rotation_b[number, :, first + i] = np.cross(face_normal(step.face), np.eye(3)[k])
    return excitation.C_sb @ rotation_b[excitation.step]


FACE_TILT = Effect(
    name="fixture.face_tilt",
    meaning="Tilt of one face of the cube",
    about=(
        "With it up, everything is seen turned, at rest and in turns. Coefficient x_up.y is the component of the "
        "up vector along y with the cube on its face x_up. Half of what the two faces of a pair have in common "
        "is parallelism. Plausible: 1e-3 rad, 0.4 mm on 400 mm."
    ),
    unit="rad",
    physics="up seen in the cube on a face = its normal + tilt",
    source="Yao, Hu, He 2018, tables 2 and 3",
    plausible=1e-3,
    columns=face_columns,
    next_measurement="certificate",
    separate_by="a certificate of the faces, or the IMU re-mounted by 90 deg in the cube",
    separate_by_certified="the IMU re-mounted by 90 deg in the cube",
    is_turn=True,
    is_held_at_prior=True,
    covered_by="fixture.parallelism",
    carried_with="cube",
)


PARALLELISM = Effect(
    name="fixture.parallelism",
    meaning="Parallelism of opposite faces",
    about=(
        "The sum of their tilts, half on each. Coefficient x.y is the sum of x_up.y and x_down.y. Per axis, the "
        "two other pairs' along it are one with the bias and K2. Plausible: 1e-3 rad, 0.4 mm on 400 mm."
    ),
    unit="rad",
    physics="up tilts of opposite faces = p/2 each",
    source="Yao, Hu, He 2018, tables 2 and 3, items t8, t9, t10",
    plausible=1e-3,
    columns=pair_columns,
    next_measurement="remounted",
    separate_by="a certificate of the faces, or the IMU re-mounted by 90 deg in the cube",
    separate_by_certified="the IMU re-mounted by 90 deg in the cube",
    is_turn=True,
    is_bench_parameter=True,
    is_held_at_prior=True,
)
