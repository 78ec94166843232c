"""The twelve positions of the cube, its faces, and how it stands in each.

Positions are Yao, Hu, He 2018, table 1: each letter says where the cube's x, y, z point
(Up, Down, East, West, North, South); 13..24 are the other attitudes of a cube. Frames as in `procedures.frames`.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES, rotation, slab_C_ln, vertical_rotation

POSITIONS = ("UEN", "UWS", "DNE", "DSW", "SUW", "NUE", "WDS", "EDN", "NWU", "SEU", "ESD", "WND")
OTHER_ATTITUDES = ("UNW", "USE", "DES", "DWN", "EUS", "WUN", "NDW", "SDE", "ENU", "WSU", "NED", "SWD")
ATTITUDES = POSITIONS + OTHER_ATTITUDES  # all in which a cube can stand along the slab's marks; numbered from 1
FACES = ("x_up", "x_down", "y_up", "y_down", "z_up", "z_down")
TURN_START = {"x": 1, "y": 5, "z": 9}
_DIRECTION = {
    "E": (1.0, 0.0, 0.0), "W": (-1.0, 0.0, 0.0),
    "N": (0.0, 1.0, 0.0), "S": (0.0, -1.0, 0.0),
    "U": (0.0, 0.0, 1.0), "D": (0.0, 0.0, -1.0),
}  # fmt: skip


def nominal_C_lb(position: int) -> FloatArray:
    """Return the rotation (3, 3) from the cube's axes to the slab's marks of position 1..24."""
    return np.array([_DIRECTION[letter] for letter in ATTITUDES[position - 1]]).T


def position_name(position: int) -> str:
    """Return what people call position 1..24: the number of the twelve, where x, y, z point of the others."""
    return str(position) if position <= len(POSITIONS) else ATTITUDES[position - 1]


def face_of(position: int) -> str:
    """Return the resting face of position 1..24, named by the cube axis that points up: ``x_up`` ..."""
    letters = ATTITUDES[position - 1]
    axis = next(i for i, letter in enumerate(letters) if letter in "UD")
    return f"{AXES[axis]}_{'up' if letters[axis] == 'U' else 'down'}"


def face_normal(face: str) -> FloatArray:
    """Return the nominal up vector (3,), a unit vector, in the cube's axes of a face such as ``x_down``."""
    axis, direction = face.split("_")
    normal = np.zeros(3)
    normal[AXES.index(axis)] = 1.0 if direction == "up" else -1.0
    return normal


def cross_axes(face: str) -> tuple[int, int]:
    """Return the indices of the two other cube axes of a face, in x, y, z order."""
    first, second = (i for i in range(3) if AXES[i] != face[0])
    return first, second


def face_rotation(face: str, up_tilt: FloatArray) -> FloatArray:
    """Return the small rotation (3, 3) that a face's tilt adds between the nominal cube and the cube.

    ``up_tilt`` (2,) [rad] holds the components of the slab normal along the two other cube axes
    when the cube rests with ``face`` up; the face adds no twist about the vertical.
    """
    tilt = np.zeros(3)
    tilt[list(cross_axes(face))] = up_tilt
    return rotation(np.cross(face_normal(face), tilt))


def C_bn(position: int, slab_tilt: FloatArray, up_tilt: FloatArray, heading: float = 0.0) -> FloatArray:
    """Return the rotation (3, 3) from East-North-Up to the cube as it stands.

    ``slab_tilt`` (2,) and ``up_tilt`` (2,) as in `slab_C_ln` and `face_rotation`; ``heading`` [rad] is how far
    the cube is turned counter-clockwise about the slab's normal from the position's nominal heading.
    """
    nominal = nominal_C_lb(position).T @ vertical_rotation(-heading)
    return face_rotation(face_of(position), up_tilt) @ nominal @ slab_C_ln(slab_tilt)
