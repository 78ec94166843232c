"""Normal equations of a chain: node i is tied to node i + 1 and to nothing else, so the matrix is a band.

``D`` (n, d, d) are the blocks on the diagonal, ``U`` (n - 1, d, d) those above it, ``g`` (n, d) the gradient.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solveh_banded

from procedures.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class BlockTridiagonal:
    """Half of the second derivative of a cost over a chain, block by block, and half of its gradient."""

    D: FloatArray
    U: FloatArray
    g: FloatArray


def solve_chain(chain: BlockTridiagonal) -> tuple[FloatArray, FloatArray]:
    """Return the step (n, d) to the minimum, in the units of the nodes, and the covariance (d, d) of the last."""
    n, d = chain.g.shape
    right = np.zeros((n * d, 1 + d))
    right[:, 0] = -chain.g.ravel()
    right[-d:, 1:] = np.eye(d)
    solved = solveh_banded(_upper_band(chain), right, overwrite_ab=True, overwrite_b=True, check_finite=False)
    return solved[:, 0].reshape(n, d), solved[-d:, 1:]


def _upper_band(chain: BlockTridiagonal) -> FloatArray:
    """Return the matrix in LAPACK's upper band storage: element (i, j) at row w + i - j, w = 2 d - 1."""
    n, d = chain.g.shape
    band = np.zeros((2 * d, n, d))
    for row in range(d):
        for column in range(d):
            if row <= column:
                band[2 * d - 1 + row - column, :, column] = chain.D[:, row, column]
            band[d - 1 + row - column, 1:, column] = chain.U[:, row, column]
    return band.reshape(2 * d, n * d)


def eliminate(A: FloatArray, B: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what a node leaves to its neighbour when it is eliminated: ``-B' A^-1 B`` and ``-B' A^-1 a``.

    Parameters
    ----------
    A, B, a : (d, d), (d, d), (d,)
        The node's own block, its tie and its gradient, in the units of its state (the Schur complement).
    """
    factor = cho_factor(A, check_finite=False)
    return -B.T @ cho_solve(factor, B, check_finite=False), -B.T @ cho_solve(factor, a, check_finite=False)
