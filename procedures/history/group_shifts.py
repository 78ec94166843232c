"""Whether a cube, a slab, a site or an operator shifts a parameter.

A group g is all calibrations made with one cube (or on one slab, at one site, by one operator). Only a unit that
was calibrated both in g and outside it tells; in d_j = (its mean in g) - (its mean outside) its own value is gone:

    d_j = delta + v_j + e_j,    v_j ~ N(0, omega^2),    e_j ~ N(0, s_j^2),    s_j^2 from the calibrations' sigmas

v_j is what the unit itself did meanwhile: turn-on scatter and ageing. All that is assumed is that it differs from
unit to unit, so ageing between the cube of last year and that of this year is no alarm. omega by Mandel and Paule;
delta is the mean weighted with w_j = 1 / (s_j^2 + omega^2), and t = delta sqrt(sum w_j) has Student's distribution
with m - 1 degrees of freedom (Hartung and Knapp, Statist. Med. 20, 3875, 2001: with this omega the scatter by
which they scale the sigma is the one expected; where it is less, at omega = 0, no use is made of it).
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import t

from procedures.arrays import BoolArray, FloatArray

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
