"""Sagnac sine of an open-loop FOG: it puts out ``sin(s u) / s`` for u, s the Sagnac phase per rate.

What is added, sin(s u) / s - u = -q u^3 / 6 + q^2 u^5 / 120 - ..., is linear to first order in ``q = s^2``, which
is fitted; s has the std sqrt(q + std q) - sqrt(q). Of a negative q, no phase at all, s is given as -sqrt(-q).
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import effect_of
from procedures.effects.excitation import Columns, Excitation, per_axis
from procedures.effects.term.functions import SERIES_BELOW, sine_less_one
from procedures.effects.term.law import Law
from procedures.frames import AXES

PLAUSIBLE = 5e-3  # rad/(deg/s)


def columns(excitation: Excitation) -> list[Columns]:
    """Return -u^3 / 6 per sensor [deg/s per (rad/(deg/s))^2]: coefficients are q."""
    return [Columns(AXES, gyro=per_axis(-(excitation.omega**3) / 6), plausible=(PLAUSIBLE**2,) * 3)]


def added(excitation: Excitation, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sin(s u) / s - u (n, 3) [deg/s] and its derivative (n, 3, 3) by q = s^2 (3,)."""
    u = excitation.omega
    total: FloatArray = u * sine_less_one(q * u**2)
    return total, per_axis(u**3 * _slope(q * u**2))


def _slope(y: FloatArray) -> FloatArray:
    """Return the derivative of `sine_less_one` by y."""
    x = np.sqrt(np.maximum(abs(y), SERIES_BELOW))
    sine = np.where(y > 0, np.sin(x), np.sinh(x)) / x
    slope = (np.where(y > 0, np.cos(x), np.cosh(x)) - sine) / (2 * np.where(y > 0, x**2, -(x**2)))
    return np.where(abs(y) < SERIES_BELOW, -1 / 6 + y / 60 - y**2 / 1680, slope)


def shown(q: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return s (3,) [rad/(deg/s)] and its 1 sigma (3,) for ``q`` (3,) and its 1 sigma ``std`` (3,)."""
    s = np.sqrt(abs(q))
    return np.sign(q) * s, np.sqrt(abs(q) + std) - s


def fitted(s: FloatArray) -> FloatArray:
    """Return q (3,) [(rad/(deg/s))^2] for ``s`` (3,): the inverse of `shown`."""
    return s * abs(s)


EFFECT = effect_of(
    "gyroscope.sagnac_sine",
    Law(terms=("u * sine(c * u**2)",), unit="(rad/(deg/s))^2"),  # sine(y) = sin(x) / x - 1 of y = x^2
    unit="rad/(deg/s)",
    plausible=PLAUSIBLE,
    physics="sin(s u) / s - u",
    meaning="Sagnac sine of an open-loop FOG",
    about="It puts out sin(s u) / s for u, s the Sagnac phase per rate. What is fitted is q = s^2. A negative q "
    "is no phase at all (s is then given as -sqrt(-q)): it says that the output grows faster than the rate. "
    "Plausible: 5e-3 rad/(deg/s), 90 deg of phase at 300 deg/s. A cubic nonlinearity is the same to first order.",
    source="H. C. Lefevre, The Fiber-Optic Gyroscope, chapter 2: response of the interferometer",
    columns=columns,
    separate_by="a rate table up to rates where s u is near 1, where sine and cubic part",
    added=added,
    shown=shown,
    fitted=fitted,
    is_loss=True,
)
