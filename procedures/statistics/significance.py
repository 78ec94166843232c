"""Tail probabilities as logarithms, corrections for multiple tests, outliers of small samples.

The significance of one more value, given others of one mean and one scatter, both unknown:

    y_i = mu + r_i + e_i,    r_i ~ N(0, tau^2),    e_i ~ N(0, s_i^2) known

mu has no prior, each decade of tau is as likely as the next, on a fine grid. With ``w_i = 1 / (s_i^2 + tau^2)``
and sums over the values at hand

    m = sum w y / sum w,   log p(y | tau) = 1/2 sum log w - 1/2 log sum w - 1/2 (sum w y^2 - m sum w y) + constant
    y ~ N(m, 1 / sum w + tau^2 + s^2), mixed over tau with these probabilities.

Where tau is all, this is Student's t with n - 1 degrees of freedom (Box and Tiao, Bayesian Inference in
Statistical Analysis, 1973, 2.4); where the s_i are all, a normal distribution.
"""

from collections.abc import Hashable, Mapping
from math import erfc, sqrt
from typing import NamedTuple, TypeVar

import numpy as np
from scipy.special import betainc, betaln, gammaincc, gammaln, ndtr

from procedures.arrays import FloatArray

LEADING_TERMS_BELOW = 1e-200  # below which the leading terms are used
LAST_TERM_NATS = 40  # -ln of the last term of a series
STD_PER_MAD = 1.482602  # 1 sigma over the median of absolute deviations, of a normal distribution
KNOWN_VARIANCE_DOF = 1e6  # degrees of freedom beyond which a variance is known


def log_chi2_sf(chi2: float, k: float) -> float:
    """Return ln P(X > chi2) for chi-square of k degrees of freedom."""
    a, x = k / 2, chi2 / 2
    p = float(gammaincc(a, x))
    if p > LEADING_TERMS_BELOW:
        return float(np.log(p))
    series, term = 1.0, 1.0  # Gamma(a, x) ~ x^(a-1) e^-x (1 + (a-1)/x + ...), Abramowitz and Stegun 6.5.32
    for i in range(1, 8):
        term *= (a - i) / x
        series += term
    return float((a - 1) * np.log(x) - x - gammaln(a) + np.log(series))


def log_f_sf(f: float, k: int, dof: float) -> float:
    """Return ln P(F > f) for k and dof degrees of freedom; chi-square / k where dof is infinite.

    P = I_x(dof/2, k/2) at x = dof / (dof + k f), far out by its hypergeometric series (Abramowitz and Stegun
    26.5.23).
    """
    if dof > KNOWN_VARIANCE_DOF:
        return log_chi2_sf(k * f, k)
    if f <= 0:
        return 0.0
    a, b, x = dof / 2, k / 2, dof / (dof + k * f)
    p = float(betainc(a, b, x))
    if p > LEADING_TERMS_BELOW:
        return float(np.log(p))
    i = np.arange(int(LAST_TERM_NATS / (1 - x)))
    series = 1 + float(np.sum(np.cumprod((a + b + i) / (a + 1 + i) * x)))
    return float(a * np.log(x) + b * np.log1p(-x) - np.log(a) - betaln(a, b) + np.log(series))


Name = TypeVar("Name", bound=Hashable)


def two_sided(sigmas: float) -> float:
    """Return the probability that a standard normal number is so far from 0 or farther."""
    return erfc(abs(sigmas) / sqrt(2.0))


def holm(p_values: Mapping[Name, float]) -> dict[Name, float]:
    """Return the p-values adjusted for their number.

    One is below alpha by chance in alpha of all sets at most, however the tests depend on each other. Source:
    Holm, Scand. J. Statist. 6, 65, 1979.
    """
    adjusted, largest = dict[Name, float](), 0.0
    for rank, name in enumerate(sorted(p_values, key=lambda one: p_values[one])):
        largest = adjusted[name] = min(max(largest, (len(p_values) - rank) * p_values[name]), 1.0)
    return {name: adjusted[name] for name in p_values}


TAU_LEVELS_PER_DECADE = 24  # levels of tau: a long series knows tau to a few per cent
WIDEST_TAU, NARROWEST_TAU = 20.0, 0.1  # times the range seen, times the median sigma


def tau_levels(value: FloatArray, std: FloatArray, per_decade: int = TAU_LEVELS_PER_DECADE) -> FloatArray:
    """Return scatters tau (k,) in equal ratios, from what is as good as 0 to far beyond the range seen.

    ``value`` and 1 sigma ``std`` are (n,), in any unit, which tau has too.
    """
    own = float(np.median(std))
    largest = WIDEST_TAU * max(float(np.ptp(value)), own)
    smallest = max(NARROWEST_TAU * own, 1e-4 * largest)
    return np.geomspace(smallest, largest, 1 + int(np.ceil(per_decade * np.log10(largest / smallest))))


class TauSums(NamedTuple):
    """Sums of log w, w, w y and w y^2, each (k, n): for each level of tau and each value to be judged by them."""

    log: FloatArray
    one: FloatArray
    first: FloatArray
    second: FloatArray


def tau_terms(tau: FloatArray, value: FloatArray, std: FloatArray) -> TauSums:
    """Return the terms of the sums, each (k, n).

    Parameters
    ----------
    tau : (k,), in the unit of the values
    value, std : (n,), 1 sigma
    """
    weight = 1.0 / (std**2 + tau[:, None] ** 2)
    return TauSums(np.log(weight), weight, weight * value, weight * value**2)


def tail_probabilities(
    sums: TauSums, tau: FloatArray, value: FloatArray, std: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the probabilities (n,) to be below and above each value.

    Parameters
    ----------
    sums : over the values that it is judged by
    tau : (k,), in the unit of the values
    value, std : (n,), 1 sigma
    """
    weight, mean, spread = predicted_mean(sums, tau)
    sigmas = (value - mean) / np.hypot(spread, std)
    below, above = (weight * ndtr(sigmas)).sum(0), (weight * ndtr(-sigmas)).sum(0)
    return below, above


def predicted_mean(sums: TauSums, tau: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return weights of sum 1, means and standard deviations (k, n) of one more value without its own error.

    ``tau`` (k,) is in the unit of the values.
    """
    mean = sums.first / sums.one
    log = 0.5 * (sums.log - np.log(sums.one) - (sums.second - mean * sums.first))
    weight = np.exp(log - log.max(0))
    return weight / weight.sum(0), mean, np.sqrt(1.0 / sums.one + tau[:, None] ** 2)


def robust_std(values: FloatArray) -> float:
    """Return 1 sigma of values (n,) by the median of their deviations from the median, 0 of none."""
    return STD_PER_MAD * float(np.median(np.abs(values - np.median(values)))) if len(values) else 0.0
