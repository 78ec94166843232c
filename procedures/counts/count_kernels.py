"""Recursions over one dwell's cumulative count, compiled: numpy has no fast form of them.

The model is a random walk about a polynomial, seen through intervals: ``S = B theta + W``, where W is
a Wiener process of ``noise`` counts per sqrt(sample) with a free level in every gap-free segment, and
"the cumulative count is c at node i" says ``low_i <= S_i < low_i + 1``. A Gaussian stand-in for that
statement, ``exp(-tau S^2 / 2 + nu S)``, is a *site*; expectation propagation (Minka 2001) finds the sites
whose product has the moments that each true interval gives it in turn.

Every kernel has its plain form as ``kernel.py_func``; the tests hold both equal. The two that are called from
Python carry their signature and are compiled once, at the install, with what they call.
"""

import math

import numpy as np
from numba import njit

from procedures.arrays import FloatArray

INITIAL_STATEMENTS = 30.0
SQRT_HALF = math.sqrt(0.5)
# Sigmas outside its interval at which a node's statement cannot be met (e^-450; erfc nears underflow)
MAX_INTERVAL_SIGMAS = 30.0


@njit(cache=True)
def interval_moments(a: float, b: float) -> tuple[float, float, float]:
    """Return log probability, mean and variance of a unit normal held to ``a <= x < b``.

    ``a`` is below `MAX_INTERVAL_SIGMAS`, ``b`` above its negative.
    """
    side = 1.0
    if a + b < 0:  # mirror: the tail that matters is the upper one, where erfc keeps its digits
        a, b, side = -b, -a, -1.0
    if (b - a) * max(b, 1.0) < 1e-2:  # the density is flat here, and differences of erfc lose their digits
        middle = 0.5 * (a + b)
        log_p = -0.5 * middle * middle - 0.9189385332046727 + math.log(b - a)
        return log_p, side * middle, (b - a) ** 2 / 12
    p = 0.5 * (math.erfc(a * SQRT_HALF) - math.erfc(b * SQRT_HALF))
    density_a = math.exp(-0.5 * a * a) * 0.3989422804014327
    density_b = math.exp(-0.5 * b * b) * 0.3989422804014327
    mean = (density_a - density_b) / p
    variance = 1 + (a * density_a - b * density_b) / p - mean * mean
    return math.log(p), side * mean, max(variance, 1e-12)


@njit(cache=True)
def invert(matrix: FloatArray) -> tuple[FloatArray, float]:
    """Return the inverse (p, p) and log determinant of a small positive definite ``matrix`` (p, p) (Gauss-Jordan).

    numpy's own would have numba load LAPACK, which takes longer than a campaign's counts.
    """
    p = len(matrix)
    inverse = matrix.copy()
    log_determinant = 0.0
    for i in range(p):
        pivot = inverse[i, i]
        log_determinant += math.log(pivot)
        inverse[i, i] = 1.0
        for k in range(p):
            inverse[i, k] /= pivot
        for j in range(p):
            if j != i:
                factor = inverse[j, i]
                inverse[j, i] = 0.0
                for k in range(p):
                    inverse[j, k] -= factor * inverse[i, k]
    return inverse, log_determinant


@njit("Tuple((f8[:], f8[:], f8[:], f8[:,:], f8))(f8[:], f8[:], f8[:], f8[:], f8[:,:], f8)", cache=True)
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
    [[A, -T B], [-B'T, B'T B]]; S is eliminated by a tridiagonal factorisation, its marginal variances
    come back from the usual backward recursion.
    """
    m, p = basis.shape
    link = np.zeros(m)  # precision of the step from node i - 1 to i
    log_norm = 0.0
    for i in range(1, m):
        if linked[i] > 0:
            link[i] = 1.0 / (noise * noise * (t[i] - t[i - 1]))
            log_norm += 0.5 * math.log(link[i])
    TB = np.zeros((m, p))
    BTB = np.zeros((p, p))
    for i in range(1, m):
        for j in range(p):
            step = link[i] * (basis[i, j] - basis[i - 1, j])
            TB[i, j] += step
            TB[i - 1, j] -= step
            for k in range(p):
                BTB[j, k] += step * (basis[i, k] - basis[i - 1, k])
    pivot = np.empty(m)
    rhs = np.empty((m, p + 1))
    for i in range(m):
        pivot[i] = tau[i] + link[i] + (link[i + 1] if i + 1 < m else 0.0)
        rhs[i, 0] = nu[i]
        for j in range(p):
            rhs[i, j + 1] = TB[i, j]
        if i > 0:
            factor = link[i] / pivot[i - 1]
            pivot[i] -= link[i] * factor
            for j in range(p + 1):
                rhs[i, j] += factor * rhs[i - 1, j]
        log_norm -= 0.5 * math.log(pivot[i])
    variance = np.empty(m)
    for i in range(m - 1, -1, -1):
        follow = link[i + 1] / pivot[i] if i + 1 < m else 0.0
        variance[i] = 1.0 / pivot[i] + (follow * follow * variance[i + 1] if i + 1 < m else 0.0)
        for j in range(p + 1):
            rhs[i, j] = rhs[i, j] / pivot[i] + (follow * rhs[i + 1, j] if i + 1 < m else 0.0)
    information = BTB.copy()
    h = np.zeros(p)
    quadratic = 0.0
    for i in range(m):
        quadratic += nu[i] * rhs[i, 0]
        for j in range(p):
            h[j] += TB[i, j] * rhs[i, 0]
            for k in range(p):
                information[j, k] -= TB[i, j] * rhs[i, k + 1]
    covariance, log_determinant = invert(information)
    theta = np.zeros(p)
    for j in range(p):
        for k in range(p):
            theta[j] += covariance[j, k] * h[k]
        quadratic += h[j] * theta[j]
    log_norm += 0.5 * quadratic - 0.5 * log_determinant
    mean = rhs[:, 0].copy()
    for i in range(m):
        for j in range(p):
            mean[i] += rhs[i, j + 1] * theta[j]
            for k in range(p):
                variance[i] += rhs[i, j + 1] * covariance[j, k] * rhs[i, k + 1]
    return mean, variance, theta, covariance, log_norm


@njit("Tuple((f8, f8, f8, i8))(f8[:], f8[:], f8[:], f8[:], f8[:], f8[:,:], f8, i8, f8)", cache=True)
def propagate(
    t: FloatArray, linked: FloatArray, low: FloatArray, tau: FloatArray, nu: FloatArray,
    basis: FloatArray, noise: float, sweeps: int, tolerance: float,
) -> tuple[float, float, float, int]:  # fmt: skip
    """Refine the sites ``tau``, ``nu`` (m,) in place until theta[0] moves by less than ``tolerance`` of its sigma.

    The sites start as those of a uniform remainder, but all together they say no more than `INITIAL_STATEMENTS` of
    them would: where the output hardly moves, neighbours repeat each other. Returns theta[0], its variance, the
    log evidence and the sweeps taken; the evidence is -inf where the noise is too small for any path through the
    intervals.

    Parameters
    ----------
    t, linked, basis, noise : (m,), (m,), (m, p) and counts per sqrt(sample), as `smooth` takes them
    low : (m,) the least that S can have been at a node [counts]
    tau, nu : (m,), written to
    sweeps : at the most
    tolerance : of theta[0]'s sigma
    """
    m = len(t)
    for i in range(m):
        tau[i] = 12.0 * min(1.0, INITIAL_STATEMENTS / m)
        nu[i] = tau[i] * (low[i] + 0.5)
    mean, variance, theta, covariance, log_norm = smooth(t, linked, tau, nu, basis, noise)
    evidence = 0.0
    sweep = 0
    while sweep < sweeps:
        sweep += 1
        evidence = log_norm
        damping = 0.9 if sweep < 3 else 0.6
        for i in range(m):
            precision = max(1.0 / variance[i] - tau[i], 1e-3 / variance[i])
            v = 1.0 / precision
            c = v * (mean[i] / variance[i] - nu[i])
            s = math.sqrt(v)
            if not (low[i] - c < MAX_INTERVAL_SIGMAS * s and c - low[i] - 1.0 < MAX_INTERVAL_SIGMAS * s):
                return theta[0], covariance[0, 0], -math.inf, sweep
            log_p, x, w = interval_moments((low[i] - c) / s, (low[i] + 1.0 - c) / s)
            evidence += log_p + 0.5 * math.log(1 + tau[i] * v)
            evidence -= 0.5 * ((c / v + nu[i]) ** 2 / (precision + tau[i]) - c * c / v)
            new_tau = max(1.0 / (w * v) - precision, 0.0)
            new_nu = (c + s * x) / (w * v) - c / v
            tau[i] += damping * (new_tau - tau[i])
            nu[i] += damping * (new_nu - nu[i])
        before = theta[0]
        mean, variance, theta, covariance, log_norm = smooth(t, linked, tau, nu, basis, noise)
        if abs(theta[0] - before) < tolerance * math.sqrt(covariance[0, 0]) and sweep > 2:
            break
    return theta[0], covariance[0, 0], evidence, sweep
