"""From an accuracy to tolerances: the cheapest items under which an estimator's worst case stays within it.

An item costs ``weight / tolerance``. Its tolerances minimise the total under `procedures.tolerance.worst_case`, a
polynomial with positive coefficients: in the logarithms of the tolerances a convex problem (geometric program), so
the minimum found is the only one.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, brentq, minimize

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import ITEMS
from procedures.tolerance.worst_case import WorstCase
from procedures.units import UG_PER_G

MAX_ITEM_RAD = 1e-2  # rad: what does not matter is not let grow beyond any cube
MIN_ITEM_RAD = 1e-9  # rad: 0.4 nm on 400 mm
KEPT_TOLERANCE_SHARE = 0.02  # an allowed tolerance within 2 % of the present one is the present one


class AccuracyUnreachable(ValueError):
    """No cube gives the accuracy: a perfect one leaves ``left`` of the ``wanted`` error [g]."""

    def __init__(self, wanted: float, left: float) -> None:
        self.wanted, self.left = wanted, left
        super().__init__(
            f"wanted a bias within {wanted * UG_PER_G:.4g} ug, but on a perfect cube this estimator is off by "
            f"{left * UG_PER_G:.4g} ug; ask for more, or use another estimator"
        )


@dataclass(frozen=True, slots=True)
class AllowedTolerance:
    """One item: tolerance at present, allowed by the cheapest cube, and allowed while no other changes [rad].

    ``alone`` is None where the accuracy is missed however fine this one item is. ``saving`` is what going from the
    present tolerance to the allowed one saves, as a part of the present cost of all items; negative if it costs.
    """

    item: str
    present: float
    allowed: float
    alone: float | None
    saving: float

    @property
    def change(self) -> str:
        """``relax``, ``tighten`` or ``keep``."""
        ratio = self.allowed / self.present
        return "keep" if abs(ratio - 1) <= KEPT_TOLERANCE_SHARE else "relax" if ratio > 1 else "tighten"


def allowed_tolerances(
    bound: WorstCase, wanted: float, present: FloatArray, weight: FloatArray
) -> list[AllowedTolerance]:
    """Return what each item may be for all of the bound's errors to stay within ``wanted``, largest saving first.

    ``present`` (11,) [rad] and ``weight`` (11,) are positive; only the weights' ratios matter.

    Raises
    ------
    AccuracyUnreachable
        A perfect cube is not good enough.
    """
    if not (np.all(present > 0) and np.all(weight > 0)):
        raise ValueError(f"tolerances {present.tolist()} and weights {weight.tolist()}: expected all above zero")
    best = cheapest_items(bound, wanted, weight)
    saving = weight * (1 / present - 1 / best) / np.sum(weight / present)
    found = [
        AllowedTolerance(
            item, float(present[i]), float(best[i]), _alone(bound, wanted, present, i), float(saving[i])
        )
        for i, item in enumerate(ITEMS)
    ]
    return sorted(found, key=lambda one: -one.saving)


def cheapest_items(bound: WorstCase, wanted: float, weight: FloatArray) -> FloatArray:
    """Return the items (11,) [rad] of least cost by ``weight`` (11,) with every error within ``wanted``."""
    if (left := float(bound.largest(np.zeros(len(ITEMS))).max())) >= wanted:
        raise AccuracyUnreachable(wanted, left)
    start = np.log(np.sqrt(weight / weight.max()))

    def excess(lead: float) -> float:
        return float(np.log(max(bound.largest(np.exp(start + lead)).max(), 1e-300) / wanted))

    lead = brentq(excess, np.log(MIN_ITEM_RAD) - 20, np.log(MAX_ITEM_RAD) + 20)
    start = np.clip(start + lead, np.log(MIN_ITEM_RAD), np.log(MAX_ITEM_RAD))
    unit = float(np.sum(weight * np.exp(-start)))

    def cost(x: FloatArray) -> float:
        return float(np.sum(weight * np.exp(-x))) / unit

    def cost_slope(x: FloatArray) -> FloatArray:
        return -weight * np.exp(-x) / unit

    def margin(x: FloatArray) -> FloatArray:
        return 1 - bound.at(np.exp(x)).ravel() / wanted

    def margin_slope(x: FloatArray) -> FloatArray:
        return -(bound.slope(np.exp(x)) * np.exp(x)).reshape(-1, len(x)) / wanted

    found = minimize(
        cost,
        start,
        jac=cost_slope,
        method="SLSQP",
        bounds=Bounds(np.log(MIN_ITEM_RAD), np.log(MAX_ITEM_RAD)),
        constraints=NonlinearConstraint(margin, 0.0, np.inf, jac=margin_slope),
        tol=1e-12,
        options={"maxiter": 500},
    )
    if not found.success:
        raise ArithmeticError(f"the cheapest tolerances were not found: {found.message}")
    return np.exp(found.x)


def _alone(bound: WorstCase, wanted: float, present: FloatArray, i: int) -> float | None:
    def excess(size: float) -> float:
        changed = present.copy()
        changed[i] = size
        return float(bound.largest(changed).max() / wanted - 1)

    if excess(0.0) > 0:
        return None
    return MAX_ITEM_RAD if excess(MAX_ITEM_RAD) <= 0 else float(brentq(excess, 0.0, MAX_ITEM_RAD, xtol=1e-15))
