"""Weighted non-linear least squares with priors: Gauss-Newton, the normal matrix's inverse as covariance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import svd
from scipy.special import chdtri

from procedures.arrays import FloatArray

MAX_ITERATIONS = 12
CONVERGED_SIGMAS = 1e-3  # sigma of any observation by which the last step still moved it; the next is its square
DIFFERENCE_STEP = 1e-4  # of a parameter's scale, for central differences


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The minimum: parameters (p,), covariance (p, p), whitened residual (n,) and its Jacobian (n, p)."""

    x: FloatArray
    covariance: FloatArray
    residual: FloatArray
    jacobian: FloatArray

    @property
    def chi2(self) -> float:
        """Sum of squares of the whitened residual, priors included."""
        return float(self.residual @ self.residual)

    @property
    def dof(self) -> int:
        """Rows, priors included, less parameters."""
        rows, columns = self.jacobian.shape
        return int(rows - columns)

    @property
    def leverage(self) -> FloatArray:
        """Share (n,) of each row's variance that the fit absorbs: the residual's variance is one less that.

        By its own rows: the covariance may hold more, such as what effects in addition to the model leave open.
        """
        Q = np.linalg.qr(self.jacobian / np.linalg.norm(self.jacobian, axis=0))[0]
        absorbed: FloatArray = np.sum(Q**2, axis=1)
        return absorbed

    def birge_ratio(self, rows: int, p_value: float, explained: float = 0.0) -> float:
        """Return by how much wider sigma is than the first ``rows`` rows say, ``explained`` of chi2 aside.

        1 where chi2 is more likely than ``p_value``, else the root of chi2 over what these rows leave free (Birge,
        Phys. Rev. 40, 1932).
        """
        chi2 = self.chi2 - explained
        if chi2 <= chdtri(self.dof, p_value):
            return 1.0
        free = float(np.sum(1 - self.leverage[:rows])) - bool(explained)
        return float(np.sqrt(max(chi2 / max(free, 1.0), 1.0)))


def minimise(
    residual: Callable[[FloatArray], FloatArray], start: FloatArray, scale: FloatArray, *, at_once: bool = False
) -> Fit:
    """Minimise the sum of squares of a whitened residual.

    Parameters
    ----------
    residual : takes parameters (p,) to whitened residuals (n,)
    start : (p,), in the parameters' units
    scale : (p,), the size at which each parameter bends the model: differences are taken over a small part of
        it, and the normal equations are solved in its units
    at_once : ``residual`` takes (..., p) to (..., n): all differences are one call
    """
    x = np.array(start, dtype=np.float64)
    for _ in range(MAX_ITERATIONS):
        r, J = residual(x), _jacobian(residual, x, scale, at_once)
        step, *_ = np.linalg.lstsq(J, -r, rcond=None)
        x += step * scale
        if np.max(np.abs(J @ step)) < CONVERGED_SIGMAS:
            break
    root = np.linalg.inv(np.linalg.qr(J, mode="r"))  # the normal matrix would square the condition number
    covariance = root @ root.T * np.outer(scale, scale)
    return Fit(x, covariance, residual(x), J / scale)


@np.errstate(all="ignore")  # what overflows is not finite, and None is the answer
def minimise_if_determined(
    residual: Callable[[FloatArray], FloatArray], start: FloatArray, scale: FloatArray, *, at_once: bool = False
) -> Fit | None:
    """Minimise as `minimise`; None where the observations leave a parameter open, or none fits.

    Parameters
    ----------
    residual, start, scale, at_once : residuals (n,) of parameters (p,), (p,), (p,) in their units; see `minimise`
    """
    try:
        fit = minimise(residual, start, scale, at_once=at_once)
    except np.linalg.LinAlgError:
        return None
    return fit if np.all(np.isfinite(fit.x)) and np.all(np.isfinite(fit.covariance)) else None


def joined_rows(x: FloatArray, *parts: FloatArray) -> FloatArray:
    """Return parts (..., i, j) or (..., k) of what parameters ``x`` (..., p) leave, no unit, as rows (..., n)."""
    return np.concatenate([part.reshape(*x.shape[:-1], -1) for part in parts], axis=-1)


def _jacobian(
    residual: Callable[[FloatArray], FloatArray], x: FloatArray, scale: FloatArray, at_once: bool
) -> FloatArray:
    step = np.diag(DIFFERENCE_STEP * scale)
    moved = x + np.stack((step, -step))
    ahead, behind = residual(moved) if at_once else np.array([[residual(each) for each in way] for way in moved])
    return np.ascontiguousarray((ahead - behind).T / (2 * DIFFERENCE_STEP))


def left_singular(A: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the left singular vectors (n, m), no unit, and the singular values (m,) of A (n, k), in its unit."""
    try:
        U, size, _ = np.linalg.svd(A, full_matrices=False)
    except np.linalg.LinAlgError:  # divide and conquer gives up on columns that hardly differ
        U, size, _ = svd(A, full_matrices=False, lapack_driver="gesvd")
    return U, size
