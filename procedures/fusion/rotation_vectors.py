"""Rotation vectors of many rotations at once."""

import numpy as np

from procedures.arrays import FloatArray


def log_rotation(C: FloatArray) -> FloatArray:
    """Return the rotation vectors (..., 3) [rad] of matrices (..., 3, 3) that turn by less than half a turn."""
    sine_axis = np.stack(
        (C[..., 2, 1] - C[..., 1, 2], C[..., 0, 2] - C[..., 2, 0], C[..., 1, 0] - C[..., 0, 1]), axis=-1
    )
    sine = np.linalg.norm(sine_axis, axis=-1) / 2
    angle = np.arctan2(sine, (np.trace(C, axis1=-2, axis2=-1) - 1) / 2)
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)
    vector: FloatArray = sine_axis / 2 * scale[..., None]
    return vector
