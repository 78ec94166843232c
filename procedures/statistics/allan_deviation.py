"""Overlapping Allan deviation with confidence limits.

Source: Riley, Handbook of Frequency Stability Analysis, NIST SP 1065 (2008): deviation sec. 5.2.3, equivalent
degrees of freedom sec. 5.4.1 table 5, power-law noise identification by lag-1 autocorrelation sec. 5.5.6.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv

from procedures.arrays import FloatArray, IntArray

MIN_SAMPLES = 9
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


def averaging_factors(samples: int, per_octave: int = 3) -> IntArray:
    """Return averaging factors (m,), numbers of samples, even in the logarithm, from 1 to a quarter of all."""
    octaves = np.log2(max(samples // 4, 1))
    return np.unique(np.round(2.0 ** np.arange(0, octaves + 1e-9, 1 / per_octave))).astype(np.int64)


def overlapping_deviation(
    rate: FloatArray | IntArray, period: float, factors: IntArray | None = None, confidence: float = 0.95
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
    confidence : float
        Probability between ``low`` and ``high``.

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
    tail = (1 - confidence) / 2
    low: FloatArray = deviation * np.sqrt(edf / (2 * gammaincinv(edf / 2, 1 - tail)))
    high: FloatArray = deviation * np.sqrt(edf / (2 * gammaincinv(edf / 2, tail)))
    tau: FloatArray = factors * np.float64(period)
    return AllanDeviation(tau, deviation, low, high, edf)


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
