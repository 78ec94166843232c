"""Overlapping Allan deviation with confidence limits, and the noise terms fitted to it.

Source: Riley, Handbook of Frequency Stability Analysis, NIST SP 1065 (2008): deviation sec. 5.2.3, equivalent
degrees of freedom sec. 5.4.1 table 5, power-law noise identification by lag-1 autocorrelation sec. 5.5.6.

With the rate in R the squared deviations of quantisation, random walk, bias instability, rate random walk and ramp
are (IEEE Std 952-2020 annex on Allan variance, IEEE Std 647):

    3 Q^2 / tau^2 + N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3 + R^2 tau^2 / 2

The squared coefficients are fitted together by generalised least squares. A point has the variance ``2 V^2 / edf``
of the fitted curve V; two points hang together as their filters overlap in the noise's spectrum S, ``sum H_i H_j
S^2`` in the limit of long records, ``H = sin^4(pi f tau) / (pi f tau)^2``. Where the terms leave more than noise
allows, their sigmas grow with it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls
from scipy.special import gammaincinv

from procedures.arrays import FloatArray, IntArray
from procedures.statistics.significance import log_chi2_sf

MIN_SAMPLES = 9
CONFIDENCE = 0.95  # probability between the limits of a deviation or a coefficient
MAX_OVERLAP = 256  # starts within an averaging time; more say the same again
# Decimated points; SP 1065 5.5.6 takes 30, where one white record in five is named wrongly
_MIN_IDENTIFIED_POINTS = 128


@dataclass(frozen=True, slots=True, eq=False)
class AllanDeviation:
    """A curve: ``tau`` (n,) [s]; ``deviation`` and its limits ``low``, ``high`` (n,) in the unit of the rate.

    ``edf`` (n,) are the equivalent degrees of freedom behind the limits.
    """

    tau: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    edf: FloatArray


def averaging_factors(samples: int) -> IntArray:
    """Return averaging factors (m,), numbers of samples, three an octave, from 1 to a quarter of all."""
    octaves = np.log2(max(samples // 4, 1))
    return np.unique(np.round(2.0 ** np.arange(0, octaves + 1e-9, 1 / 3))).astype(np.int64)


def overlapping_deviation(
    rate: FloatArray | IntArray, period: float, factors: IntArray | None = None
) -> AllanDeviation:
    """Return the overlapping Allan deviation of a gap-free record.

    Parameters
    ----------
    rate : (n,) float64 or int64
        Mean rate over each interval; increments in counts give a deviation in counts per interval.
    period : float
        Interval [s].
    factors : (m,) int64, optional
        Intervals averaged; `averaging_factors` if not given.

    Raises
    ------
    ValueError
        If there are fewer than `MIN_SAMPLES` samples.
    """
    n = len(rate)
    if n < MIN_SAMPLES:
        raise ValueError(f"an Allan deviation of {n} samples, expected at least {MIN_SAMPLES}")
    factors = averaging_factors(n) if factors is None else factors
    centred = np.asarray(rate, dtype=float) - np.mean(rate)
    phase: FloatArray = np.concatenate(([0.0], np.cumsum(centred)))
    deviation, edf, exponent = np.empty(len(factors)), np.empty(len(factors)), 0
    for i, m in enumerate(factors):
        stride = max(int(m) // MAX_OVERLAP, 1)
        second = phase[2 * m :: stride] - 2 * phase[m:-m:stride] + phase[: -2 * m : stride]
        deviation[i] = np.sqrt(np.mean(second**2) / 2) / m
        exponent = _exponent(phase[::m], exponent)
        edf[i] = _equivalent_dof(exponent, n + 1, int(m))
    tail = (1 - CONFIDENCE) / 2
    low, high = (deviation * np.sqrt(edf / (2 * gammaincinv(edf / 2, p))) for p in (1 - tail, tail))
    return AllanDeviation(factors * np.float64(period), deviation, low, high, edf)


def _exponent(phase: FloatArray, known: int) -> int:
    """Return the power-law exponent of the rate's spectrum, +2 white phase to -2 random walk of the rate."""
    if len(phase) < _MIN_IDENTIFIED_POINTS:
        return known
    differences = 0
    while True:
        centred = phase - phase.mean()
        power = float(centred @ centred)
        r1 = float(centred[1:] @ centred[:-1]) / power if power > 0 else 0.0
        delta = r1 / (1 + r1) if r1 > -1 else -0.5
        if delta < 0.25 or differences == 2:
            return int(np.clip(round(2 - 2 * (delta + differences)), -2, 2))
        phase, differences = np.diff(phase), differences + 1


def _equivalent_dof(exponent: int, n: int, m: int) -> float:
    """Return SP 1065 table 5 for ``n`` phase points and averaging factor ``m``."""
    if exponent == 2:
        dof = (n + 1) * (n - 2 * m) / (2 * (n - m))
    elif exponent == 1:
        dof = np.exp(np.sqrt(np.log((n - 1) / (2 * m)) * np.log((2 * m + 1) * (n - 1) / 4)))
    elif exponent == 0:
        dof = (3 * (n - 1) / (2 * m) - 2 * (n - 2) / n) * 4 * m**2 / (4 * m**2 + 5)
    elif exponent == -1:
        dof = 2 * (n - 2) ** 2 / (2.3 * n - 4.9) if m == 1 else 5 * n**2 / (4 * m * (n + 3 * m))
    else:
        dof = (n - 2) / m * ((n - 1) ** 2 - 3 * m * (n - 1) + 4 * m**2) / (n - 3) ** 2
    return max(float(dof), 1.0)


TERMS = ("quantisation", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp")
MIN_CHI2 = 9.0  # by which a fit without a term must be worse: three sigma
RAMP = TERMS.index("rate_ramp")
RAMP_PRICE = 0.3  # of it more for a ramp: a random walk that happens to go one way is likelier
MIN_DOF = 1.5  # of a point that is fitted
ROUNDS = 3  # of weights by the curve fitted before
MIN_RELATIVE_STD = 0.003  # of a point, independent of all others: what the limit of long records is off
FREQUENCIES = 2048  # at which spectra are summed


@dataclass(frozen=True, slots=True)
class NoiseTerm:
    """A term's coefficient with its interval; ``value`` is None where the curve only bounds it by ``high``."""

    value: float | None
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class NoiseFit:
    """The terms by name (`TERMS`), and ln p of what they leave of the curve."""

    terms: Mapping[str, NoiseTerm]
    log_p: float


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """Squared coefficients (k,) of the terms ``used``, their covariance (k, k), and the chi-square left."""

    used: tuple[int, ...]
    squared: FloatArray
    covariance: FloatArray
    chi2: float


def noise_shapes(tau: FloatArray) -> Mapping[str, FloatArray]:
    """Return each term's deviation (n,) per unit coefficient at ``tau`` [s] (IEEE Std 952).

    With the rate in R: ``quantisation`` [R s], ``random_walk`` [R sqrt(s)] (angle or velocity random walk),
    ``bias_instability`` [R], ``rate_random_walk`` [R / sqrt(s)], ``rate_ramp`` [R / s].
    """
    shapes = (
        np.sqrt(3.0) / tau, 1 / np.sqrt(tau), np.full_like(tau, np.sqrt(2 * np.log(2) / np.pi)),
        np.sqrt(tau / 3), tau / np.sqrt(2),
    )  # fmt: skip
    return dict(zip(TERMS, shapes, strict=True))


def fit_noise(curve: AllanDeviation, quantum: float = 0.0) -> NoiseFit:
    """Fit the noise terms to a curve, as many as it supports.

    A term has a value with its 95 % interval (chi-square, of the degrees of freedom that its relative sigma stands
    for), else a bound: no term can exceed the curve's upper limit. ``quantum`` is what one count is, in the unit
    of the rate times seconds: what counting alone explains, up to sqrt(2) quantum / tau, is quantisation only.
    """
    shapes = np.array(list(noise_shapes(curve.tau).values())).T
    seen = curve.deviation > 0
    if not seen.any():
        return NoiseFit(dict.fromkeys(TERMS, NoiseTerm(None, 0.0, 0.0)), 0.0)
    bounds = np.min(curve.high[seen, None] / shapes[seen], axis=0)
    rows = _fitted_rows(curve)
    allowed = _allowed(curve, shapes, quantum)
    found = _supported(curve.tau[rows], curve.deviation[rows] ** 2, curve.edf[rows], shapes[rows] ** 2, allowed)
    dof = len(rows) - len(found.used)
    wider = max(found.chi2 / dof, 1.0) if dof > 0 else 1.0
    terms = {name: NoiseTerm(None, 0.0, float(bounds[k])) for k, name in enumerate(TERMS)}
    for i, k in enumerate(found.used):
        if found.squared[i] > 0:
            terms[TERMS[k]] = _with_interval(found.squared[i], found.covariance[i, i] * wider)
    return NoiseFit(terms, log_chi2_sf(found.chi2, dof) if dof > 0 else 0.0)


def _fitted_rows(curve: AllanDeviation) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the points (m,) that are fitted, about an octave apart: those between say the same again."""
    usable = np.flatnonzero((curve.deviation > 0) & (curve.edf >= MIN_DOF))
    usable = usable if len(usable) else np.flatnonzero(curve.deviation > 0)[:1]
    rows = [int(usable[0])]
    for i in usable[1:]:
        if curve.tau[i] > 1.9 * curve.tau[rows[-1]]:
            rows.append(int(i))
    return np.array(rows)


def _allowed(curve: AllanDeviation, shapes: FloatArray, quantum: float) -> tuple[int, ...]:
    """Return the terms that may have a value: those not largest where counting alone explains the curve."""
    above = curve.deviation > np.sqrt(2) * quantum / curve.tau
    if above.all():
        return tuple(range(len(TERMS)))
    seen = curve.deviation > 0
    squares = shapes[seen] ** 2
    weight = np.sqrt(curve.edf[seen] / 2) / curve.deviation[seen] ** 2
    fitted, _ = nnls(weight[:, None] * squares, weight * curve.deviation[seen] ** 2)
    share = squares * fitted
    best = np.argmax(share / np.maximum(share.sum(axis=1, keepdims=True), np.finfo(float).tiny), axis=0)
    above = above[seen]
    return tuple(k for k in range(len(TERMS)) if k == 0 or above[best[k]])


def _supported(
    tau: FloatArray, squares: FloatArray, edf: FloatArray, shapes: FloatArray, allowed: Sequence[int]
) -> _Fit:
    """Return the fit of the terms that a curve supports: each makes it better by `MIN_CHI2`, the ramp by more."""
    weight = np.sqrt(edf / 2) / squares
    c, _ = nnls(weight[:, None] * shapes, weight * squares)
    L = np.linalg.cholesky(_relative_covariance(tau, edf, c)).astype(np.float64)
    subsets = [used for size in range(1, len(allowed) + 1) for used in combinations(allowed, size)]
    fits = [_fit(squares, shapes, weight, L, used) for used in subsets if len(used) <= len(tau)]
    best = min(each.chi2 / max(len(tau) - len(each.used), 1) for each in fits)
    price = MIN_CHI2 * max(best, 1.0)
    return min(fits, key=lambda each: each.chi2 + price * (len(each.used) + RAMP_PRICE * (RAMP in each.used)))


def _fit(
    squares: FloatArray, shapes: FloatArray, weight: FloatArray, L: FloatArray, used: tuple[int, ...]
) -> _Fit:
    """Fit some terms, weighted by what the curve would scatter if it were as fitted; L L' is relative."""
    X = shapes[:, list(used)]
    c, _ = nnls(weight[:, None] * X, weight * squares)
    for _ in range(ROUNDS):
        V = np.maximum(X @ c, 1e-3 * squares)
        A, b = (solve_triangular(L, each, lower=True) for each in (X / V[:, None], squares / V))
        c, left = nnls(A, b)
    active = c > 0
    covariance = np.zeros((len(c), len(c)))
    covariance[np.ix_(active, active)] = np.linalg.pinv(A[:, active].T @ A[:, active])
    return _Fit(used, c, covariance, float(left**2))


def _relative_covariance(tau: FloatArray, edf: FloatArray, c: FloatArray) -> FloatArray:
    """Return the covariance (n, n) of the squared deviations over the fitted ones."""
    f = np.geomspace(1e-2 / tau[-1], 0.5 / tau[0], FREQUENCIES)
    w = 2 * np.pi * f
    spectra = (w**2 * tau[0], np.ones_like(f), 1 / w, 1 / w**2, 1 / w**3)
    S = np.sum([size * each for each, size in zip(spectra, c, strict=True)], axis=0)
    x = np.pi * f * tau[:, None]
    H = np.sin(x) ** 4 / x**2 * S * np.sqrt(f)  # even in the logarithm of f
    product = H @ H.T
    size = np.sqrt(np.diag(product))
    together = product / np.maximum(size[:, None] * size, np.finfo(float).tiny)
    std = np.sqrt(2 / edf)
    own = np.full(len(tau), MIN_RELATIVE_STD**2) + 1e-6 * std**2
    found: FloatArray = together * std[:, None] * std + np.diag(own)
    return found


def _with_interval(squared: float, variance: float) -> NoiseTerm:
    """Return a coefficient whose square has a variance: chi-square with as many degrees of freedom."""
    dof = max(2 * squared**2 / variance, 0.5) if variance > 0 else 1e12
    tail = (1 - CONFIDENCE) / 2
    low, high = (squared * dof / (2 * gammaincinv(dof / 2, p)) for p in (1 - tail, tail))
    return NoiseTerm(float(np.sqrt(squared)), float(np.sqrt(low)), float(np.sqrt(high)))
