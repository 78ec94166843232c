"""Which face is up, from raw count rates alone: never through a stored calibration.

At rest the accelerometer that stands upright counts g and the two others next to nothing. That holds for any
scale factors that agree to some per cent and biases of some mg; count rates are taken to grow with specific force.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import FACES, face_normal

LIMIT_DEG = 5.0  # biases of 40 mg and scale factors 10 % apart still pass


def seen_face(accel: FloatArray, C_ib: FloatArray) -> tuple[str, float]:
    """Return the face that is up and by how much it seems off the vertical [deg].

    ``accel`` (3,) is the accelerometers' count rate in IMU axes; ``C_ib`` (3, 3) takes the cube's axes to those.
    """
    in_cube = C_ib.T @ accel
    face = max(FACES, key=lambda name: float(face_normal(name) @ in_cube))
    upright = float(face_normal(face) @ in_cube)
    level = float(np.linalg.norm(in_cube - upright * face_normal(face)))
    return face, float(np.degrees(np.arctan2(level, upright)))


def remark(accel: FloatArray, C_ib: FloatArray, wanted: str) -> str:
    """Return in words what is wrong with the face that is up, empty if nothing is."""
    face, off = seen_face(accel, C_ib)
    if off > LIMIT_DEG:
        return f"tilted by {off:.0f} deg, limit {LIMIT_DEG:g} deg"
    return "" if face == wanted else f"{words(face)}, expected {words(wanted)}"


def words(face: str) -> str:
    """Return a face such as ``x_up`` in words."""
    return f"{face[0].upper()} points {face[2:]}"
