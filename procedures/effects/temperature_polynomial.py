"""Polynomials of temperature about 25 degC, one a sensor, each of its own order.

Which order is for the data to say (`procedures.inference.hypotheses`). The coefficient of the n-th power is
plausibly as large as makes it as much as the first at 30 K from the reference.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES

SPAN_K = 30.0  # from the reference, at which all powers may be alike
FIRST_ORDERS = (1, 2, 3)  # with which a search begins
MAX_ORDER = 6
MAX_LAGGED_ORDER = 3  # of a temperature that is itself inferred


def names(orders: tuple[int, ...]) -> tuple[str, ...]:
    """Return the coefficients' names: x, y, z of straight lines, else x.1, x.2, ..., y.1, ..."""
    if max(orders) == 1:
        return tuple(AXES)
    return tuple(f"{axis}.{n}" for axis, order in zip(AXES, orders, strict=True) for n in range(1, order + 1))


def orders_of(keys: list[str]) -> tuple[int, ...]:
    """Return the orders (3,) that coefficients' names stand for: the inverse of `names`."""
    parts = [key.partition(".") for key in keys]
    return tuple(max([int(n or 1) for name, _, n in parts if name == axis], default=1) for axis in AXES)


def powers(value: FloatArray, orders: tuple[int, ...]) -> FloatArray:
    """Return columns (n, 3, k) of a value (n,) [K] at the powers of each sensor, in K^n."""
    found = np.zeros((len(value), 3, sum(orders)))
    column = 0
    for sensor, order in enumerate(orders):
        for n in range(1, order + 1):
            found[:, sensor, column] = value**n
            column += 1
    return found


def plausible(first: float, orders: tuple[int, ...]) -> tuple[float, ...]:
    """Return 1 sigma of what each coefficient may be, in the unit of the first over K^(n - 1)."""
    return tuple(first / SPAN_K ** (n - 1) for order in orders for n in range(1, order + 1))
