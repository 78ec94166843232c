"""Three accelerometers from rests in unknown attitudes, by the norm alone: ``|K^-1 (N - b)| = g``.

The norm says nothing of how the frame is turned. `NormFit` therefore has E lower triangular: the frame's x axis is
sensor x's input axis, its y axis lies in the plane of sensors x and y (Gram-Schmidt in this order).
Source of the method: Tedaldi, Pretto, Menegatti, ICRA 2014, who take E upper triangular and minimise the squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.sample_records import Series
from procedures.rests_and_moves.rest_detection import ScatterLevel
from procedures.statistics.least_squares import Fit, minimise_if_determined

LOWER_TRIANGLE = np.tril_indices(3)
MIN_RESTS = 10  # nine numbers and one to judge the residual by
MULTIPLIERS_TRIED = (1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0)  # of the variance of a quiet window
LOOSE_MULTIPLIERS = (50.0, 100.0, 200.0)  # where none of these gives rests enough: held by hand, never quite still
USUAL_MULTIPLIER = 3.0  # the multiplier where the rests are too few to choose one by
REWEIGHTINGS, MAX_NEWTON_STEPS = 4, 50  # of weighting anew by the scatter found, and of finding it
MAX_ELLIPSOID_CONDITION = 1e8  # condition of an ellipsoid's matrix: axes as 1 to 10^4
MAX_RELATIVE_SCALE_STD = 0.1  # relative 1 sigma of k above which the rests are said not to determine it


@dataclass(frozen=True, slots=True, eq=False)
class NormFit:
    """K (3, 3) [output/s per g], lower triangular, b (3,) [output/s], the fit behind them, residual (n,) [g].

    ``excess`` [g] is the scatter of the norm from rest to rest beyond noise, as in `excess_scatter`.
    """

    K: FloatArray
    b: FloatArray
    fit: Fit
    residual: FloatArray
    excess: float

    @property
    def spread(self) -> float:
        """Mean variance of k, relative, and of D [g]."""
        k = np.diag(self.K)
        return float(np.mean(np.diag(self.fit.covariance)[[0, 2, 5, 6, 7, 8]] / np.tile(k, 2) ** 2))


@np.errstate(all="ignore")  # outputs beyond all bounds determine nothing
def fit_norm(rate: FloatArray, std: FloatArray, gravity: float) -> NormFit | None:
    """Fit K and b to rests; None where they do not determine them.

    ``rate`` and ``std`` (n, 3) [output/s] are their outputs and 1 sigma, ``gravity`` [g] the norm they have.
    """
    start = _ellipsoid(rate, gravity)
    if start is None:
        return None
    K, b = start
    noise, excess = norm_sigma(K, b, rate, std), 0.0
    x = np.concatenate((K[LOWER_TRIANGLE], b))
    for _ in range(REWEIGHTINGS):
        sigma = np.hypot(noise, excess)
        scale = np.full(9, np.max(np.abs(K)) * 0.1)
        found = minimise_if_determined(partial(_misfit, rate, gravity, sigma), x, scale, at_once=True)
        if found is None:
            return None
        fit = found
        x, excess = fit.x, excess_scatter(fit.residual * sigma, noise, fit.dof)
    K, b = _lower(x), x[6:]
    if np.any(np.sqrt(np.diag(fit.covariance)[[0, 2, 5]]) > MAX_RELATIVE_SCALE_STD * np.abs(np.diag(K))):
        return None
    return NormFit(K, b, fit, fit.residual * sigma, excess)


def excess_scatter(residual: FloatArray, noise: FloatArray, free: float) -> float:
    """Return the scatter common to all rows that brings their weighted squares to the ``free`` degrees of freedom.

    ``residual`` and ``noise``, 1 sigma, are (n,). Source: Mandel and Paule, Anal. Chem. 42, 1970; Newton's steps
    approach the root of this falling, convex function from below.
    """
    variance = 0.0
    for _ in range(MAX_NEWTON_STEPS):
        weight = 1 / (noise**2 + variance)
        over = float(np.sum(weight * residual**2)) - free
        if over <= 0:
            break
        variance += over / float(np.sum((weight * residual) ** 2))
    return float(np.sqrt(variance))


def _lower(x: FloatArray) -> FloatArray:
    K = np.zeros((*x.shape[:-1], 3, 3))
    K[..., *LOWER_TRIANGLE] = x[..., :6]
    return K


def _misfit(rate: FloatArray, gravity: float, sigma: FloatArray, x: FloatArray) -> FloatArray:
    u = np.linalg.solve(_lower(x), np.swapaxes(rate - x[..., None, 6:], -1, -2))
    found: FloatArray = (np.linalg.norm(u, axis=-2) - gravity) / sigma
    return found


def norm_sigma(K: FloatArray, b: FloatArray, rate: FloatArray, std: FloatArray) -> FloatArray:
    """Return 1 sigma (n,) [g] of the norm of ``K^-1 (rate - b)``.

    Parameters
    ----------
    K, b : (3, 3) [output/s per g], (3,) [output/s]
    rate, std : (n, 3) [output/s], 1 sigma
    """
    u = np.linalg.solve(K, (rate - b).T).T
    weight = np.linalg.solve(K.T, (u / np.linalg.norm(u, axis=1)[:, None]).T).T
    sigma: FloatArray = np.linalg.norm(weight * std, axis=1)
    return sigma


def _ellipsoid(rate: FloatArray, gravity: float) -> tuple[FloatArray, FloatArray] | None:
    """Fit the quadric ``v' M v + 2 m' v = 1`` to the outputs; None unless it is an ellipsoid."""
    if len(rate) < MIN_RESTS:
        return None
    middle, size = (np.asarray(f(rate, axis=0), dtype=np.float64) for f in (np.mean, np.std))
    if np.any(size <= 0):
        return None
    v = (rate - middle) / size
    x, y, z = v.T
    A = np.stack((x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z), axis=1)
    xx, yy, zz, xy, xz, yz, *m = np.linalg.lstsq(A, np.ones(len(v)), rcond=None)[0]
    M = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if (
        not np.all(np.isfinite(M))
        or np.linalg.cond(M) > MAX_ELLIPSOID_CONDITION
        or np.any(np.linalg.eigvalsh(M) <= 0)
    ):
        return None
    centre = -np.linalg.solve(M, m)
    inverse = np.linalg.inv(M / (1 + centre @ M @ centre)) / gravity**2
    return np.asarray(np.linalg.cholesky(inverse * np.outer(size, size)), dtype=np.float64), middle + centre * size


def choose_rests(activity: ScatterLevel, gravity: float) -> tuple[float, list[slice]]:
    """Return the threshold's multiplier and the rests that leave k and D least uncertain.

    The fit's covariance has the scatter that its residual shows in it: a multiplier too small throws rests away,
    and the covariance grows; one too large lets movement in, and the residual and with it the covariance grow.
    The smallest residual alone, the usual choice, would reward having few rests.
    """
    for multipliers in (MULTIPLIERS_TRIED, LOOSE_MULTIPLIERS):
        found: list[tuple[float, float, list[slice]]] = []
        for multiplier in multipliers:
            rests = activity.rests(multiplier)
            fit = _quick_fit(activity.series, rests, gravity)
            if fit is not None and fit.fit.dof > 0:
                found.append((fit.spread, multiplier, rests))
        if found:
            _, multiplier, rests = min(found, key=lambda each: each[:2])
            return multiplier, rests
    return USUAL_MULTIPLIER, activity.rests(USUAL_MULTIPLIER)


def _quick_fit(series: Series, rests: Sequence[slice], gravity: float) -> NormFit | None:
    if series.accel is None or len(rests) < MIN_RESTS:
        return None
    parts = [np.asarray(series.accel[rest], dtype=np.float64) for rest in rests]
    mean = np.array([samples.mean(axis=0) for samples in parts])
    noise = np.sqrt(np.mean([np.var(np.diff(samples, axis=0), axis=0) / 2 for samples in parts], axis=0))
    std = np.maximum(noise, np.spacing(np.abs(mean).max())) / np.sqrt([[len(samples)] for samples in parts])
    return fit_norm(mean, std, gravity)
