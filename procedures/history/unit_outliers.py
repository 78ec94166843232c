"""Units that stand out among all units of a model, one parameter at a time.

    y_j = mu + u_j + e_j,    u_j ~ N(0, omega^2),    e_j ~ N(0, s_j^2) known

Each unit is judged against the others, whose mean and scatter are unknown
(`procedures.statistics.small_sample_outlier`): p is the probability of a value so far out. One unit that is far
off hides a second; so the most extreme is taken out and the rest judged again, up to a fifth of the fleet, and all
are reported up to the last that is significant (generalised extreme Studentised deviate: Rosner, Technometrics 25,
165, 1983), with p times the number of units it was the most extreme of.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.statistics.small_sample_outlier import (
    TauSums,
    predicted_mean,
    tail_probabilities,
    tau_levels,
    tau_terms,
)

MIN_UNITS = 5  # units: with fewer, one that is off cannot be told from a wide fleet
MAX_EXTREME_SHARE, MAX_EXTREMES = 0.2, 20  # of the fleet, and in all


@dataclass(frozen=True, slots=True)
class ExtremeUnit:
    """A unit that may stand out: its index, ``shift`` from the others' mean, 1 sigma of that, adjusted p."""

    unit: int
    shift: float
    std: float
    p_adjusted: float


@dataclass(frozen=True, slots=True)
class FleetParameter:
    """The middle of a fleet, its scatter (1.4826 times the median deviation; None of one unit), its extremes."""

    median: float
    spread: float | None
    extremes: tuple[ExtremeUnit, ...]


def judge_fleet(value: FloatArray, std: FloatArray) -> FleetParameter:
    """Judge units by their ``value`` and ``std``, both (n,); ``extremes`` are none below `MIN_UNITS` units."""
    middle = float(np.median(value))
    offset = value - middle
    spread = float(1.4826 * np.median(np.abs(offset))) if len(value) > 1 else None
    left, found = np.arange(len(value)), list[ExtremeUnit]()
    for _ in range(min(int(MAX_EXTREME_SHARE * len(value)), MAX_EXTREMES) if len(value) >= MIN_UNITS else 0):
        i = _most_extreme(offset[left], std[left])
        unit, others = int(left[i]), np.delete(left, i)
        found.append(_judged(offset, std, others, unit))
        left = others
    return FleetParameter(middle, spread, tuple(found))


def significant(extremes: tuple[ExtremeUnit, ...], alpha: float) -> tuple[ExtremeUnit, ...]:
    """Return the extremes up to the last one that is significant at ``alpha``."""
    last = max((i for i, one in enumerate(extremes) if one.p_adjusted <= alpha), default=-1)
    return extremes[: last + 1]


def _most_extreme(value: FloatArray, std: FloatArray) -> int:
    """Return the index of the value least probable among the others: the sums less its own term."""
    tau = tau_levels(value, std)
    terms = tau_terms(tau, value, std)
    others = (part.sum(1, keepdims=True) - part for part in terms)
    return int(np.argmin(np.minimum(*tail_probabilities(TauSums(*others), tau, value, std))))


def _judged(value: FloatArray, std: FloatArray, others: IntArray, unit: int) -> ExtremeUnit:
    tau = tau_levels(value[others], std[others])
    terms = tau_terms(tau, value[others], std[others])
    sums = TauSums(*(part.sum(1, keepdims=True) for part in terms))
    p = 2 * float(np.minimum(*tail_probabilities(sums, tau, value[[unit]], std[[unit]]))[0])
    weight, mean, spread = predicted_mean(sums, tau)
    middle = float((weight * mean).sum())
    variance = float((weight * (spread**2 + (mean - middle) ** 2)).sum()) + float(std[unit]) ** 2
    return ExtremeUnit(
        unit, float(value[unit]) - middle, float(np.sqrt(variance)), min(1.0, p * (len(others) + 1))
    )
