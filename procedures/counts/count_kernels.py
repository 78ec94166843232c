"""Recursions over one dwell's cumulative count, whole vectors at a time.

The model is a random walk about a polynomial, seen through intervals: ``S = B theta + W``, where W is
a Wiener process of ``noise`` counts per sqrt(sample) with a free level in every gap-free segment, and
"the cumulative count is c at node i" says ``low_i <= S_i < low_i + 1``. A Gaussian stand-in for that
statement, ``exp(-tau S^2 / 2 + nu S)``, is a *site*; expectation propagation (Minka 2001) finds the sites
whose product has the moments that each true interval gives it in turn.

LAPACK's tridiagonal factorisation is the recursion. Compiled loops take a third of the time for the few hundred
nodes of a dwell, but their compiler takes longer to load than a whole campaign to solve.
"""

import math

import numpy as np
from scipy.linalg.lapack import dpttrf, dpttrs
from scipy.special import erfc

from procedures.arrays import FloatArray

INITIAL_STATEMENTS = 30.0
SQRT_HALF = math.sqrt(0.5)
ROOT_2_PI = 1 / math.sqrt(2 * math.pi)
FLAT = 1e-2  # an interval's width times its distance, below which a normal density is flat there
# Sigmas outside its interval at which a node's statement cannot be met (e^-450; erfc nears underflow)
MAX_INTERVAL_SIGMAS = 30.0


def interval_moments(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return log probability, mean and variance (m,) of unit normals held to ``a <= x < b`` (m,).

    ``a`` is below `MAX_INTERVAL_SIGMAS`, ``b`` above its negative.
    """
    middle, half = 0.5 * (a + b), 0.5 * (b - a)
    # mirrored: the tail that matters is the upper one, where erfc keeps its digits
    at = np.abs(middle)
    ends = np.empty((2, *np.shape(at)))
    ends[0], ends[1] = at - half, at + half
    a, b = ends
    density = np.exp(-0.5 * ends**2) * ROOT_2_PI
    tails = erfc(ends * SQRT_HALF)
    p = 0.5 * (tails[0] - tails[1])
    flat = 2 * half * np.maximum(b, 1.0) < FLAT
    if flat.any():  # differences of erfc lose their digits, and the density hardly differs
        p = np.where(flat, ROOT_2_PI * np.exp(-0.5 * middle**2) * 2 * half, p)
    mean = (density[0] - density[1]) / p
    variance = np.maximum(1 + (a * density[0] - b * density[1]) / p - mean * mean, 1e-12)
    if flat.any():
        mean, variance = np.where(flat, at, mean), np.where(flat, half**2 / 3, variance)
    return np.log(p), mean * np.sign(middle), variance


def smooth(
    t: FloatArray, linked: FloatArray, tau: FloatArray, nu: FloatArray, basis: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
    """Return the posterior of S and theta under Gaussian sites.

    Returns mean (m,) and variance (m,) of S, theta (p,), its covariance (p, p) and the log of the normaliser.
    Level and theta have flat priors.

    Parameters
    ----------
    t : (m,) node times [samples]
    linked : (m,), 1 where a node continues the segment of the one before it, else 0
    tau, nu : (m,) the sites' precision and precision times mean, S in counts
    basis : (m, p) of theta at the nodes
    noise : counts per sqrt(sample)

    Notes
    -----
    With T the random walk's tridiagonal precision and A = T + diag(tau), the joint precision of (S, theta) is
    [[A, -T B], [-B'T, B'T B]]; S is eliminated by A's factorisation. With d the pivots from the first node on and
    e those from the last, A's inverse has 1 / (d + e - diag A) on its diagonal.
    """
    return _smooth(*_walk(t, linked, basis, noise), tau, nu)


def rate_terms(
    t: FloatArray, linked: FloatArray, tau: FloatArray, nu: FloatArray, basis: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Return theta (p,) and its variances (p,) as `smooth`, but the first of theta where it is the only one.

    What the sites say of it by itself is in the same factorisation: the information of a basis without the others
    is a part of the whole one.

    Parameters
    ----------
    t : (m,) node times [samples]
    linked : (m,), 1 where a node continues the segment of the one before it, else 0
    tau, nu : (m,) the sites' precision and precision times mean, S in counts
    basis : (m, p) of theta at the nodes
    noise : counts per sqrt(sample)
    """
    link, TB, BTB, _ = _walk(t, linked, basis, noise)
    pivot, factor, _ = dpttrf(_diagonal(link, tau), -link)
    level, bent = _solved(pivot, factor, TB, nu)
    information, h = BTB - TB.T @ bent, TB.T @ level
    covariance = np.linalg.inv(information)
    theta, variance = covariance @ h, np.diag(covariance).copy()
    theta[0], variance[0] = h[0] / information[0, 0], 1 / information[0, 0]
    return theta, variance


Walk = tuple[FloatArray, FloatArray, FloatArray, float]


def _walk(t: FloatArray, linked: FloatArray, basis: FloatArray, noise: float) -> Walk:
    """Return the steps' precision (m - 1,), T B (m, p), B'T B (p, p) and half the log of the steps' precision."""
    apart = noise * noise * (t[1:] - t[:-1])  # nought where a segment begins when another ended
    link = np.divide(1.0, apart, out=np.zeros(len(apart)), where=linked[1:] > 0)
    change = basis[1:] - basis[:-1]
    step = link[:, None] * change
    TB = np.zeros(basis.shape)
    TB[1:] += step
    TB[:-1] -= step
    return link, TB, step.T @ change, 0.5 * float(np.log(link[link > 0]).sum())


def _smooth(
    link: FloatArray, TB: FloatArray, BTB: FloatArray, log_norm: float, tau: FloatArray, nu: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
    diagonal = _diagonal(link, tau)
    pivot, factor, _ = dpttrf(diagonal, -link)
    back, _, _ = dpttrf(diagonal[::-1], -link[::-1])
    level, bent = _solved(pivot, factor, TB, nu)
    information = BTB - TB.T @ bent
    covariance = np.asarray(np.linalg.inv(information) if len(information) > 1 else 1.0 / information, np.float64)
    h = TB.T @ level
    theta: FloatArray = covariance @ h
    determinant = np.linalg.det(information) if len(information) > 1 else information[0, 0]
    log_norm += 0.5 * float(nu @ level + h @ theta - np.log(pivot).sum()) - 0.5 * math.log(determinant)
    variance = 1.0 / (pivot + back[::-1] - diagonal) + ((bent @ covariance) * bent).sum(axis=1)
    return level + bent @ theta, variance, theta, covariance, log_norm


def _diagonal(link: FloatArray, tau: FloatArray) -> FloatArray:
    diagonal = tau.copy()
    diagonal[1:] += link
    diagonal[:-1] += link
    return diagonal


def _solved(
    pivot: FloatArray, factor: FloatArray, TB: FloatArray, nu: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return A's solutions for ``nu`` (m,) and ``TB`` (m, p)."""
    right = np.empty((len(nu), 1 + TB.shape[1]), order="F")
    right[:, 0], right[:, 1:] = nu, TB
    solved, _ = dpttrs(pivot, factor, right)
    return solved[:, 0], solved[:, 1:]
