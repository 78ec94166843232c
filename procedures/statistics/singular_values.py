"""Singular values of columns that hardly differ: by another way where LAPACK's fast one gives up.

Divide and conquer (gesdd, in `numpy.linalg.svd`) did not converge on the steps of a walk of 85 rows and 81
columns, all finite, from 1e-31 to 4e-3; QR iterations (gesvd) take some times as long, and do.
"""

import numpy as np
from scipy.linalg import svd

from procedures.arrays import FloatArray


def left_singular(A: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the left singular vectors (n, m), no unit, and the singular values (m,) of A (n, k), in its unit."""
    try:
        U, size, _ = np.linalg.svd(A, full_matrices=False)
    except np.linalg.LinAlgError:
        U, size, _ = svd(A, full_matrices=False, lapack_driver="gesvd")
    return U, size
