"""Sagnac sine of an open-loop FOG: it puts out ``sin(s u) / s`` for u, s the Sagnac phase per rate.

What is added, sin(s u) / s - u = -q u^3 / 6 + q^2 u^5 / 120 - ..., depends on s by ``q = s^2`` alone, and to first
order is linear in it: q is what is fitted. Then s = sqrt(q), with the std sqrt(q + std q) - sqrt(q), which is
std q / (2 s) where q is well known and sqrt(std q) where it is zero. A negative q is no phase at all (s is then
given as -sqrt(-q)): it says that the output grows faster than the rate. Plausible: 5e-3 rad/(deg/s), 90 deg of
phase at 300 deg/s. A cubic nonlinearity is the same to first order.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.frames import AXES

PLAUSIBLE = 5e-3  # rad/(deg/s)
SERIES_BELOW = 1e-3  # of (s u)^2, below which series are used


def columns(excitation: Excitation) -> list[Columns]:
    """Return -u^3 / 6 per sensor [deg/s per (rad/(deg/s))^2]: coefficients are q."""
    return [Columns(AXES, gyro=per_axis(-(excitation.omega**3) / 6), plausible=(PLAUSIBLE**2,) * 3)]


def added(excitation: Excitation, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sin(s u) / s - u (n, 3) [deg/s] and its derivative (n, 3, 3) by q = s^2 (3,)."""
    u = excitation.omega
    y = q * u**2
    beyond, slope = _of_square(y)
    total: FloatArray = u * beyond
    return total, per_axis(u**3 * slope)


def sine_less_one(y: FloatArray) -> FloatArray:
    """Return sin(x) / x - 1, a number (n, 3), of ``y = x^2`` (n, 3); sinh of a negative y."""
    return _of_square(y)[0]


def _of_square(y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sin(x) / x - 1 and its derivative by y, as functions of y = x^2; sinh for negative y."""
    x = np.sqrt(np.maximum(abs(y), SERIES_BELOW))
    sine = np.where(y > 0, np.sin(x), np.sinh(x)) / x
    slope = (np.where(y > 0, np.cos(x), np.cosh(x)) - sine) / (2 * np.where(y > 0, x**2, -(x**2)))
    near = abs(y) < SERIES_BELOW
    beyond = np.where(near, -y / 6 + y**2 / 120 - y**3 / 5040, sine - 1)
    return beyond, np.where(near, -1 / 6 + y / 60 - y**2 / 1680, slope)


def shown(q: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return s (3,) [rad/(deg/s)] and its 1 sigma (3,) for ``q`` (3,) and its 1 sigma ``std`` (3,)."""
    s = np.sqrt(abs(q))
    return np.sign(q) * s, np.sqrt(abs(q) + std) - s


def fitted(s: FloatArray) -> FloatArray:
    """Return q (3,) [(rad/(deg/s))^2] for ``s`` (3,): the inverse of `shown`."""
    return s * abs(s)


EFFECT = Effect(
    name="gyroscope.sagnac_sine",
    unit="rad/(deg/s)",
    physics="sin(s u) / s - u",
    source="H. C. Lefevre, The Fiber-Optic Gyroscope, chapter 2: response of the interferometer",
    plausible=PLAUSIBLE,
    columns=columns,
    separate_by="a rate table up to rates where s u is near 1, where sine and cubic part",
    added=added,
    shown=shown,
    fitted=fitted,
    is_loss=True,
    driver="input",
)
