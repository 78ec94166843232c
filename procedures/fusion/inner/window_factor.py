"""Cholesky factors of a window's normal equations, scaled to a unit diagonal: metres and biases differ by 1e6."""

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs, dpotrf, dpotrs

from procedures.arrays import FloatArray
from procedures.fusion.inner.window_state import COMMON, FRAME


class Factor:
    """A factor of any normal equations ``A`` (n, n); raises ``LinAlgError`` where they are singular."""

    def __init__(self, A: FloatArray) -> None:
        self.size = len(A)
        self._size = 1 / np.sqrt(np.diag(A))
        self._factor = self._decomposed(A)

    def _decomposed(self, A: FloatArray) -> FloatArray:
        return _cholesky(A * self._size * self._size[:, None])

    def covariance(self, at: slice) -> FloatArray:
        """Return the covariance (k, k) of k unknowns, in their units."""
        pick = np.zeros((self.size, at.stop - at.start))
        pick[at] = np.eye(at.stop - at.start)
        covariance: FloatArray = self.solve(pick)[at]
        return covariance

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution for right sides (n,) or (n, m)."""
        size = self._size if right.ndim == 1 else self._size[:, None]
        whitened: FloatArray = size * self._solved(size * right)
        return whitened

    def _solved(self, right: FloatArray) -> FloatArray:
        solved: FloatArray = dpotrs(self._factor, right)[0]
        return solved


class ChainFactor(Factor):
    """A factor where a keyframe is tied to the next one and to what all have in common; no other ties are seen.

    Those ties are a band, ``n FRAME^2`` multiplications instead of ``n^3 / 3``; what is common is left when the
    keyframes are eliminated (a Schur complement). Of 61 keyframes it takes a tenth of the time of `Factor`.
    """

    def _decomposed(self, A: FloatArray) -> FloatArray:
        scale, keyframes = self._size[COMMON:], A[COMMON:, COMMON:]
        band = np.zeros((2 * FRAME, len(scale)))  # LAPACK's: row d has the elements d below the diagonal
        for d in range(min(2 * FRAME, len(scale))):
            band[d, : len(scale) - d] = np.diagonal(keyframes, -d) * scale[d:] * scale[: len(scale) - d]
        factor: FloatArray
        factor, failed = dpbtrf(band, lower=1, overwrite_ab=1)
        _refuse(failed and failed + COMMON)
        common = self._size[:COMMON]
        self._ties = A[:COMMON, COMMON:] * scale * common[:, None]
        self._by_common = dpbtrs(factor, self._ties.T, lower=1)[0]
        own = A[:COMMON, :COMMON] * common * common[:, None]
        self._common = _cholesky(own - self._ties @ self._by_common)
        return factor

    def _solved(self, right: FloatArray) -> FloatArray:
        alone = dpbtrs(self._factor, right[COMMON:], lower=1)[0]
        common = dpotrs(self._common, right[:COMMON] - self._ties @ alone)[0]
        return np.concatenate((common, alone - self._by_common @ common))


def _cholesky(A: FloatArray) -> FloatArray:
    factor: FloatArray
    factor, failed = dpotrf(A.T, clean=0, overwrite_a=1)  # in columns, as LAPACK has it
    _refuse(failed)
    return factor


def _refuse(failed: int) -> None:
    if failed:
        raise np.linalg.LinAlgError(f"the normal equations are singular from unknown {failed} on")
