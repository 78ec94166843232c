"""One more value beside others of one mean and one scatter, both unknown: how improbable it is.

    y_i = mu + r_i + e_i,    r_i ~ N(0, tau^2),    e_i ~ N(0, s_i^2) known

mu has no prior, each decade of tau is as likely as the next, on a fine grid. With ``w_i = 1 / (s_i^2 + tau^2)``
and sums over the values at hand

    m = sum w y / sum w,   log p(y | tau) = 1/2 sum log w - 1/2 log sum w - 1/2 (sum w y^2 - m sum w y) + constant
    y ~ N(m, 1 / sum w + tau^2 + s^2), mixed over tau with these probabilities.

Where tau is all, this is Student's t with n - 1 degrees of freedom (Box and Tiao, Bayesian Inference in
Statistical Analysis, 1973, 2.4); where the s_i are all, a normal distribution. TauSums make it cheap to
leave a value out or to take values in one by one.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from procedures.arrays import FloatArray

TAU_LEVELS_PER_DECADE = 24  # levels of tau: a long series knows tau to a few per cent
WIDEST_TAU, NARROWEST_TAU = 20.0, 0.1  # times the range seen, times the median sigma


def tau_levels(value: FloatArray, std: FloatArray, per_decade: int = TAU_LEVELS_PER_DECADE) -> FloatArray:
    """Return scatters tau (k,) in equal ratios, from what cannot be told from 0 to far beyond the range seen.

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
