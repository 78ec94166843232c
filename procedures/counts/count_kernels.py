"""Recursions over one dwell's cumulative count, whole vectors at a time.

The model is a random walk about a polynomial, seen through intervals: ``S = B theta + W``, where W is a Wiener
process of ``noise`` counts per sqrt(sample) with a free level in every gap-free segment, and "the cumulative count
is c at node i" says ``low_i <= S_i < low_i + 1``. A Gaussian stand-in for that statement, ``exp(-tau S^2 / 2 + nu
S)``, is a *site*; expectation propagation (Minka 2001) finds the sites. LAPACK's tridiagonal factorisation is the
recursion.
"""

import math

import numpy as np
from scipy.linalg.lapack import dpttrf, dpttrs
from scipy.special import erfc

from procedures.arrays import FloatArray

INITIAL_STATEMENTS = 30.0
SQRT_HALF = math.sqrt(0.5)
ROOT_2_PI = 1 / math.sqrt(2 * math.pi)
# From here on a normal density is 0 and its tail 0 or 1, to the last bit; with little noise most ends lie farther
# off, where exp and erfc take eight times as long to say so
FAR_SIGMAS = 39.0
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
    near = np.abs(ends) < FAR_SIGMAS
    density, tails = np.zeros(ends.shape), np.where(ends > 0, 0.0, 2.0)
    at_ends = ends[near]
    density[near] = np.exp(-0.5 * at_ends**2) * ROOT_2_PI
    tails[near] = erfc(at_ends * SQRT_HALF)
    p = 0.5 * (tails[0] - tails[1])
    flat = 2 * half * np.maximum(b, 1.0) < FLAT
    if flat.any():  # differences of erfc lose their digits, and the density hardly differs
        p = np.where(flat, ROOT_2_PI * np.exp(-0.5 * middle**2) * 2 * half, p)
    mean = (density[0] - density[1]) / p
    variance = np.maximum(1 + (a * density[0] - b * density[1]) / p - mean * mean, 1e-12)
    if flat.any():
        mean, variance = np.where(flat, at, mean), np.where(flat, half**2 / 3, variance)
    return np.log(p), mean * np.sign(middle), variance


def theta_of_first_and_all(
    t: FloatArray, linked: FloatArray, tau: FloatArray, nu: FloatArray, basis: FloatArray, noise: float
) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Return theta and its covariance, (1,) and (1, 1) by the basis's first column, (p,) and (p, p) by all.

    With T the random walk's tridiagonal precision and A = T + diag(tau), the joint precision of (S, theta) is
    [[A, -T B], [-B'T, B'T B]]; S is eliminated by A's factorisation, once for both. Priors are flat.

    Parameters
    ----------
    t : (m,) node times [samples]
    linked : (m,), 1 where a node continues the segment of the one before it, else 0
    tau, nu : (m,) the sites' precision and precision times mean, S in counts
    basis : (m, p) of theta at the nodes
    noise : counts per sqrt(sample)
    """
    apart = noise * noise * (t[1:] - t[:-1])  # zero where a segment begins when another ended
    link = np.divide(1.0, apart, out=np.zeros(len(apart)), where=linked[1:] > 0)
    change = basis[1:] - basis[:-1]
    step, TB, diagonal = link[:, None] * change, np.zeros_like(basis), tau.copy()
    TB[1:] += step
    TB[:-1] -= step
    diagonal[1:] += link
    diagonal[:-1] += link
    pivot, factor, _ = dpttrf(diagonal, -link)
    right = np.empty((len(nu), 1 + basis.shape[1]), order="F")
    right[:, 0], right[:, 1:] = nu, TB
    solved, _ = dpttrs(pivot, factor, right, overwrite_b=1)
    level, bent = solved[:, 0], solved[:, 1:]
    # of one column a sum of products runs as along a vector: it is one, not a column of several
    first = [np.ascontiguousarray(each[:, :1]) for each in (step, change, TB)]
    alone = _theta(first[0].T @ first[1], first[2], level, bent[:, :1])
    return alone, _theta(step.T @ change, TB, level, bent)


def _theta(BTB: FloatArray, TB: FloatArray, level: FloatArray, bent: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return theta (p,) and its covariance (p, p); ``level`` is A^-1 nu, ``bent`` A^-1 T B."""
    information = BTB - TB.T @ bent
    inverse = np.linalg.inv(information) if len(information) > 1 else 1.0 / information
    covariance = np.asarray(inverse, dtype=np.float64)
    return covariance @ (TB.T @ level), covariance
