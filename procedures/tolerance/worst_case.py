"""The worst case: how far an estimator can be off on any cube that its drawing allows.

Every face may tilt in any direction by up to the sum of the items on the way to it. The errors are expanded to the
second order in the twelve tilts: gradient L and Hessian H of the exact formulas. Over tilts of at most S_f

    error <= C + sum_f |L_f| S_f + sum_f max(0, lambda_max(H_ff)) S_f^2 / 2 + sum_f<g |H_fg| S_f S_g

with C what a perfect cube leaves (K2), |L_f| the length of a face's two slopes and |H_fg| the spectral norm of a
2 x 2 block; and likewise for the error's negative. With S = `STACK` times items that is a polynomial of the items
without a negative coefficient but C. What it leaves out is of third order, a tilt's part of the second.
`worst_corner` holds against it what corners of the allowed region give by the full formulas.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import STACK
from procedures.tolerance.estimator_errors import ToleranceUnit, estimator_errors

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
    compass = np.exp(2j * np.pi * np.arange(CORNER_DIRECTIONS) / CORNER_DIRECTIONS)
    slope = L / np.maximum(np.linalg.norm(L, axis=2, keepdims=True), 1e-300)
    found = np.zeros((rows, 2))
    for s, sign in enumerate((1.0, -1.0)):
        tilts = sign * slope * size[:, None]  # (r, 6, 2): each error has its own cube
        for face in [f for _ in range(MAX_CORNER_SWEEPS) for f in range(6)]:
            options = np.concatenate(
                (np.zeros((1, 2)), size[face] * np.stack((compass.real, compass.imag), axis=1))
            )
            tried = np.repeat(tilts[:, None], len(options) + 1, axis=1)  # (r, options, 6, 2), the first as it is
            tried[:, 1:, face] = options
            all_values = sign * quantity(np.moveaxis(tried.reshape(-1, 6, 2), 0, 2)).reshape(rows, rows, -1)
            own = all_values[range(rows), range(rows)]
            tilts = tried[range(rows), np.argmax(own, axis=1)]
            found[:, s] = own.max(axis=1)
    largest: FloatArray = found.max(axis=1)
    return largest
