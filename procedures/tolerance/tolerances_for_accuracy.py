"""The cheapest tolerances under which an estimator's worst case meets an accuracy.

An item costs ``weight / tolerance``. Its tolerances minimise the total under the worst case's bound, a polynomial
with positive coefficients: in the logarithms of the tolerances a convex problem (geometric program).

Every face may tilt in any direction by up to the sum of the items on the way to it. The errors are expanded to the
second order in the twelve tilts: gradient L and Hessian H of the exact formulas. Over tilts of at most S_f

    error <= C + sum_f |L_f| S_f + sum_f max(0, lambda_max(H_ff)) S_f^2 / 2 + sum_f<g |H_fg| S_f S_g

with C what a perfect cube leaves (K2), |L_f| the length of a face's two slopes and |H_fg| the spectral norm of a
2 x 2 block; and likewise for the error's negative. With S = `STACK` times items that is a polynomial of the items.
`worst_corner` holds against it what corners of the allowed region give by the full formulas.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, brentq, minimize

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import ITEMS, STACK
from procedures.tolerance.estimator_errors import ToleranceUnit, estimator_errors
from procedures.units import UG_PER_G

TILT_STEP_RAD = 1e-4  # rad: the third order is 1e-8 of the first, rounding 1e-8 of the second
CORNER_DIRECTIONS = 24  # directions tried in a corner: the best is missed by less than 1 % (cos 7.5 deg)
MAX_CORNER_SWEEPS = 4

Quantity = Callable[[FloatArray], FloatArray]
"""Takes tilts (6, 2, n) [rad] to errors (r, n)."""


@dataclass(frozen=True, slots=True, eq=False)
class WorstCase:
    """``constant`` (r, 2), ``linear`` (r, 2, 11) and ``quadratic`` (r, 2, 11, 11): r errors, each up and down."""

    constant: FloatArray
    linear: FloatArray
    quadratic: FloatArray

    def at(self, item: FloatArray) -> FloatArray:
        """Return the largest (r, 2) of every error and of its negative for the items ``item`` (11,) [rad]."""
        second: FloatArray = np.einsum("rsij,i,j->rs", self.quadratic, item, item)
        return self.constant + self.linear @ item + second

    def slope(self, item: FloatArray) -> FloatArray:
        """Return the derivative (r, 2, 11) [1/rad] of `at` by the items ``item`` (11,) [rad]."""
        return self.linear + 2 * self.quadratic @ item

    def largest(self, item: FloatArray) -> FloatArray:
        """Return the largest magnitude (r,) of every error for the items ``item`` (11,) [rad]."""
        largest: FloatArray = self.at(item).max(axis=1)
        return largest


def all_errors(unit: ToleranceUnit) -> Quantity:
    """Return the quantity of 21 rows: bias [g] by estimator and sensor, scale factor by sensor, misalignment."""

    def quantity(tilts: FloatArray) -> FloatArray:
        found = estimator_errors(tilts, unit)
        n = tilts.shape[2]
        return np.concatenate((found.bias.reshape(9, n), found.scale_factor, found.misalignment.reshape(9, n)))

    return quantity


def expand(quantity: Quantity) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value (r,), gradient (r, 6, 2) and Hessian (r, 6, 2, 6, 2) by tilts [rad] at none, numerically."""
    one = TILT_STEP_RAD * np.eye(12)
    pair = (one[:, None] + one[None]).reshape(-1, 12)
    apart = (one[:, None] - one[None]).reshape(-1, 12)
    points = np.concatenate((np.zeros((1, 12)), one, -one, pair, -pair, apart, -apart))
    value = quantity(points.T.reshape(6, 2, -1))
    rows = len(value)
    gradient = (value[:, 1:13] - value[:, 13:25]) / (2 * TILT_STEP_RAD)
    same_up, same_down, apart_up, apart_down = value[:, 25:].reshape(rows, 4, 12, 12).swapaxes(0, 1)
    hessian = (same_up + same_down - apart_up - apart_down) / (4 * TILT_STEP_RAD**2)
    return value[:, 0], gradient.reshape(rows, 6, 2), hessian.reshape(rows, 6, 2, 6, 2)


def worst_case(quantity: Quantity) -> WorstCase:
    """Return the worst case of a quantity as a polynomial of the items."""
    value, L, H = expand(quantity)
    block = np.moveaxis(H, 3, 2)  # (r, 6, 6, 2, 2)
    A = np.repeat(np.linalg.norm(block, ord=2, axis=(3, 4))[:, None] / 2, 2, axis=1)
    own = np.linalg.eigvalsh(block[:, range(6), range(6)])  # ascending
    A[:, 0, range(6), range(6)] = np.maximum(own[..., 1], 0) / 2
    A[:, 1, range(6), range(6)] = np.maximum(-own[..., 0], 0) / 2
    first = np.linalg.norm(L, axis=2) @ STACK
    return WorstCase(np.stack((value, -value), axis=1), np.stack((first, first), axis=1), STACK.T @ A @ STACK)


def worst_corner(quantity: Quantity, item: FloatArray) -> FloatArray:
    """Return the largest magnitudes (r,) of the full formulas in corners of what ``item`` (11,) [rad] allows.

    Face by face the best of no tilt, `CORNER_DIRECTIONS` directions and that of the slope is taken, until none is
    better.
    """
    value, L, _ = expand(quantity)
    rows = len(value)
    size = STACK @ item
    around = np.exp(2j * np.pi * np.arange(CORNER_DIRECTIONS) / CORNER_DIRECTIONS)
    compass = np.stack((around.real, around.imag), axis=1)
    slope = L / np.maximum(np.linalg.norm(L, axis=2, keepdims=True), 1e-300)
    found = np.zeros((rows, 2))
    for s, sign in enumerate((1.0, -1.0)):
        tilts = sign * slope * size[:, None]  # (r, 6, 2): each error has its own cube
        for face in [f for _ in range(MAX_CORNER_SWEEPS) for f in range(6)]:
            options = np.vstack((np.zeros(2), size[face] * compass))
            tried = np.repeat(tilts[:, None], len(options) + 1, axis=1)  # (r, options, 6, 2), the first as it is
            tried[:, 1:, face] = options
            all_values = sign * quantity(np.moveaxis(tried.reshape(-1, 6, 2), 0, 2)).reshape(rows, rows, -1)
            own = all_values[range(rows), range(rows)]
            tilts = tried[range(rows), np.argmax(own, axis=1)]
            found[:, s] = own.max(axis=1)
    largest: FloatArray = found.max(axis=1)
    return largest


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
