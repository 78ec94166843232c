"""Forward-right-down body axes against north-east-down: the frames of roll and pitch, and their conversions.

As in You and Lee and in MAVLink; the rest of the station works in East-North-Up (`procedures.frames`). At rest and
level the specific force is (0, 0, -g). ``C_nb`` takes forward-right-down to north-east-down; its last row is the
down vector.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.geodesy import earth_rate_n

ENU_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # its own inverse


def down_of(roll: FloatArray, pitch: FloatArray) -> FloatArray:
    """Return the down vector (..., 3) in body axes of roll and pitch [rad]."""
    level = np.cos(pitch)
    return np.stack([-np.sin(pitch), np.sin(roll) * level, np.cos(roll) * level], axis=-1)


def roll_pitch_of(down: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return roll and pitch [rad] of down vectors (..., 3); at pitch 90 deg roll is arbitrary."""
    x, y, z = down[..., 0], down[..., 1], down[..., 2]
    return np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))


def inclination(down: FloatArray, other: FloatArray) -> FloatArray:
    """Return the angle [rad] between ``down`` and ``other`` (..., 3): the error of roll and pitch together."""
    angle: FloatArray = np.arctan2(np.linalg.norm(np.cross(down, other), axis=-1), np.sum(down * other, axis=-1))
    return angle


def earth_rate_ned(latitude: float) -> FloatArray:
    """Return the Earth's rotation rate (3,) [rad/s] in north-east-down at a latitude [rad]."""
    return ENU_NED @ earth_rate_n(latitude)
