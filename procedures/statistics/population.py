"""Units that differ from the others of their model, and cubes, plates, sites or operators that shift a parameter.

    y_j = mu + u_j + e_j,    u_j ~ N(0, omega^2),    e_j ~ N(0, s_j^2) known

Each unit is judged against the others (`procedures.statistics.significance`): p is the probability of a value so
far out. One unit that is far off hides a second; so the most extreme is taken out and the rest judged again, and
all are reported up to the last that is significant (generalised extreme Studentised deviate: Rosner, Technometrics
25, 165, 1983), with p times the number of units it was the most extreme of.

A group g is all calibrations made with one cube (or on one slab, at one site, by one operator). Only a unit that
was calibrated both in g and outside it counts, with d_j = (its mean in g) - (its mean outside):

    d_j = delta + v_j + e_j,    v_j ~ N(0, omega^2),    e_j ~ N(0, s_j^2),    s_j^2 from the calibrations' sigmas

v_j is what the unit itself did in that time: turn-on scatter and ageing. omega by Mandel and Paule; delta is the
mean weighted with w_j = 1 / (s_j^2 + omega^2), and t = delta sqrt(sum w_j) has Student's distribution with m - 1
degrees of freedom (Hartung and Knapp, Statist. Med. 20, 3875, 2001).
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import t

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.statistics.significance import (
    TauSums,
    predicted_mean,
    robust_std,
    tail_probabilities,
    tau_levels,
    tau_terms,
)

MIN_UNITS = 5  # units: with fewer, one that is off cannot be distinguished from a wide fleet
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
    spread = robust_std(value) if len(value) > 1 else None
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


MIN_UNITS_IN_BOTH = 3  # units that were calibrated both in the group and outside it


@dataclass(frozen=True, slots=True)
class GroupShift:
    """By how much a group shifts a parameter against the other groups, 1 sigma, p, and by how many units."""

    shift: float
    std: float
    p_value: float
    units: int


def group_shift(
    unit: Sequence[Hashable], inside: BoolArray, value: FloatArray, std: FloatArray
) -> GroupShift | None:
    """Compare the calibrations inside a group with the same units' outside it.

    None where fewer than `MIN_UNITS_IN_BOTH` units have both.

    Parameters
    ----------
    unit : of n calibrations
    inside : (n,), true of those in the group
    value, std : (n,) in the parameter's unit, 1 sigma
    """
    d, variance = _contrasts(unit, inside, value, std)
    if len(d) < MIN_UNITS_IN_BOTH:
        return None
    weight = 1.0 / (variance + _between(d, variance))
    delta = float(weight @ d / weight.sum())
    sigma = float(np.sqrt(1.0 / weight.sum()))
    return GroupShift(delta, sigma, float(2 * t.sf(abs(delta) / sigma, len(d) - 1)), len(d))


def _contrasts(
    unit: Sequence[Hashable], inside: BoolArray, value: FloatArray, std: FloatArray
) -> tuple[FloatArray, FloatArray]:
    rows = dict[Hashable, list[int]]()
    for i, one in enumerate(unit):
        rows.setdefault(one, []).append(i)
    d, variance = list[float](), list[float]()
    for own in rows.values():
        here, there = ([i for i in own if inside[i] == side] for side in (True, False))
        if here and there:
            d.append(float(value[here].mean() - value[there].mean()))
            variance.append(sum(float((std[side] ** 2).sum()) / len(side) ** 2 for side in (here, there)))
    return np.array(d), np.array(variance)


def _between(d: FloatArray, variance: FloatArray) -> float:
    """Return omega^2 at which the weighted scatter of d is its degrees of freedom, 0 if it is less at once."""

    def excess(omega2: float) -> float:
        weight = 1.0 / (variance + omega2)
        return float(weight @ (d - weight @ d / weight.sum()) ** 2) - (len(d) - 1)

    if excess(0.0) <= 0:
        return 0.0
    return float(brentq(excess, 0.0, float(((d - d.mean()) ** 2).sum()), rtol=1e-10))
