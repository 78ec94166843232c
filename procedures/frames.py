"""Rotations between slab, cube and IMU.

Frames: ``n`` East-North-Up; ``l`` the slab's own marks (East, North, normal); ``b`` the cube.
"""

import math

import numpy as np

from procedures.arrays import FloatArray

AXES = ("x", "y", "z")
TRIADS = ("accelerometer", "gyroscope")
TILT_TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # takes a tilt to its rotation vector
NO_ANGLE = 1e-150  # rad, in the place of zero where an angle divides


def rotation(vector: FloatArray) -> FloatArray:
    """Return the rotation matrices (..., 3, 3) of ``vector`` (..., 3) [rad], right-handed (Rodrigues).

    With h half the angle, ``cos 2h I + sin h cos h / h [v x] + (sin h / h)^2 / 2 v v'``.
    """
    if vector.ndim == 1:
        return _rotation_of_one(*vector.tolist())
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    square = x * x + y * y + z * z
    half = np.maximum(0.5 * np.sqrt(square), NO_ANGLE)
    sinc = np.sin(half) / half
    along, across = 0.5 * sinc * sinc, sinc * np.cos(half)
    cosine = 1.0 - along * square
    result = np.empty((*vector.shape, 3))
    for i, part in enumerate((x, y, z)):
        result[..., i, i] = cosine + along * part * part
    for i, j, one, other, third in ((0, 1, x, y, z), (2, 0, z, x, y), (1, 2, y, z, x)):
        both, turned = along * one * other, across * third
        result[..., i, j], result[..., j, i] = both - turned, both + turned
    return result


def _rotation_of_one(x: float, y: float, z: float) -> FloatArray:
    """Return what `rotation` does of one vector: plain numbers take a fifth of the time of arrays of three."""
    square = x * x + y * y + z * z
    half = max(0.5 * math.sqrt(square), NO_ANGLE)
    sinc = float(np.sin(half)) / half
    along, across = 0.5 * sinc * sinc, sinc * float(np.cos(half))
    cosine = 1.0 - along * square
    return np.array((
        (cosine + along * x * x, along * x * y - across * z, along * x * z + across * y),
        (along * y * x + across * z, cosine + along * y * y, along * y * z - across * x),
        (along * z * x - across * y, along * z * y + across * x, cosine + along * z * z),
    ))  # fmt: skip


def skew(v: FloatArray) -> FloatArray:
    """Return the matrices (..., 3, 3) that take x to v cross x, of vectors (..., 3) of any unit and frame."""
    matrix = np.zeros((*v.shape[:-1], 3, 3))
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    matrix[..., 1, 2], matrix[..., 2, 0], matrix[..., 0, 1] = -v[..., 0], -v[..., 1], -v[..., 2]
    return matrix


def rotation_vector(C: FloatArray) -> FloatArray:
    """Return the rotation vectors (..., 3) [rad] of matrices ``C`` (..., 3, 3): less than half a turn."""
    sine_axis = np.stack(
        (C[..., 2, 1] - C[..., 1, 2], C[..., 0, 2] - C[..., 2, 0], C[..., 1, 0] - C[..., 0, 1]), axis=-1
    )
    sine = np.sqrt((sine_axis * sine_axis).sum(axis=-1)) / 2
    angle = np.arctan2(sine, (C[..., 0, 0] + C[..., 1, 1] + C[..., 2, 2] - 1) / 2)
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)
    return sine_axis / 2 * scale[..., None]


def wahba_rotation(B: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) C with the largest trace of C' B: for B = sum of v_n v_b', that from b to n."""
    U, _, Vt = np.linalg.svd(B)
    best: FloatArray = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    return best


def wrapped(angle: FloatArray) -> FloatArray:
    """Return ``angle`` [rad], of any shape, within half a turn of 0, in the same shape."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def slab_C_ln(tilt: FloatArray) -> FloatArray:
    """Return the rotations (..., 3, 3) from East-North-Up to the slab's marks.

    ``tilt`` (..., 2) [rad] holds the East and North components of the up vector seen from the slab.
    """
    return rotation(tilt @ TILT_TURN)


def vertical_rotation(angle: float) -> FloatArray:
    """Return the rotation (3, 3) of vectors by ``angle`` [rad], counter-clockwise seen from above."""
    return rotation(np.array([0.0, 0.0, angle]))
