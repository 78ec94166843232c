"""Thirty laws outside the catalogue, in plain numpy: the same function plants a law and judges what was found.

They were written before the library. ``along`` is of the sensor, `_2` and `_3` of the next and last axis.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

DPH = 1 / 3600.0  # deg/s of a deg/h


@dataclass(frozen=True)
class Seen:
    """What the sensors go through at n moments: g, deg/s, uT (n, 3); columns (n, 1): K above 25 degC, K/min, s.

    ``before`` (n, 3) is f in the step before; ``heat`` the warmth that turning leaves, of |omega|^2, by tau 200 s.
    """

    f: np.ndarray
    w: np.ndarray
    B: np.ndarray
    T: np.ndarray
    T_rate: np.ndarray
    t: np.ndarray
    s: np.ndarray
    before: np.ndarray
    north: np.ndarray
    east: np.ndarray
    heat: np.ndarray


@dataclass(frozen=True)
class Law:
    """A law: ``of`` gives its shape (n, 3), or (n, 3, 2) of two phases, which a size [g, deg/s] multiplies."""

    name: str
    triad: str
    design: str
    of: Callable[[Seen], np.ndarray]


def turned(v: np.ndarray, by: int) -> np.ndarray:
    """Return what is along the next axis, or by 2 the last."""
    return np.roll(v, -by, axis=1)


def phases(x: np.ndarray) -> np.ndarray:
    """Return sine and cosine (n, 3, 2) of a phase (n, 1) or (n, 3)."""
    wide = np.broadcast_to(x, (len(x), 3))
    return np.stack((np.sin(wide), np.cos(wide)), axis=2)


def locked(w: np.ndarray, width: float) -> np.ndarray:
    """Return what a ring laser's lock takes off."""
    return np.sign(w) * np.sqrt(np.maximum(0.0, w**2 - width**2)) - w


TAU = 2 * np.pi
GYRO, ACCEL = "gyroscope", "accelerometer"
LAWS = (
    Law("dead zone", GYRO, "speeds", lambda x: -x.w * np.exp(-((x.w / (12 * DPH)) ** 4))),
    Law("lock-in", GYRO, "speeds", lambda x: locked(x.w, 6 * DPH)),
    Law("polarization", GYRO, "warm", lambda x: phases(TAU * x.T / 1.7)),
    Law("source warms up", GYRO, "speeds", lambda x: x.w * np.exp(-x.t / 300)),
    Law("g squared", GYRO, "plain", lambda x: x.f**2),
    Law("next g squared", GYRO, "plain", lambda x: turned(x.f, 1) ** 2),
    Law("rectified rate", GYRO, "speeds", lambda x: turned(x.w, 1) ** 2),
    Law("two rates", GYRO, "speeds", lambda x: turned(x.w, 1) * np.abs(turned(x.w, 1))),
    Law("range ends", GYRO, "speeds", lambda x: np.clip(x.w, -60, 60) - x.w),
    Law("counts lost", GYRO, "speeds", lambda x: np.sign(x.w) * np.maximum(0, np.abs(x.w) - 25)),
    Law("fifth power", GYRO, "speeds", lambda x: x.w**5),
    Law("convection", GYRO, "plain", lambda x: x.f**2 * (1 - np.exp(-x.s / 40))),
    Law("bias warms up", GYRO, "plain", lambda x: np.exp(-x.t / 400) * np.ones((1, 3))),
    Law("self-heating", GYRO, "plain", lambda x: x.heat * np.ones((1, 3))),
    Law("temperature times its rate", GYRO, "warm", lambda x: x.T * x.T_rate * np.ones((1, 3))),
    Law("g-sensitivity with temperature", GYRO, "warm", lambda x: x.T * x.f),
    Law("cross g with temperature", GYRO, "warm", lambda x: x.T * turned(x.f, 1)),
    Law("Faraday with temperature", GYRO, "warm", lambda x: x.T * x.B),
    Law("pressure cycles", GYRO, "plain", lambda x: phases(TAU * x.t / 500)),
    Law("of the heading", GYRO, "plain", lambda x: x.north**2),
    Law("hinge remembers", ACCEL, "plain", lambda x: x.before),
    Law("cross-axis K", ACCEL, "certified free", lambda x: turned(x.f, 1) ** 2),
    Law("bow of a converter", ACCEL, "free", lambda x: phases(TAU * x.f / 0.4)),
    Law("stiction", ACCEL, "free", lambda x: -np.tanh(x.f / 0.3)),
    Law("magnet of a torquer", ACCEL, "plain", lambda x: turned(x.B, 1)),
    Law("scale ages", ACCEL, "plain", lambda x: x.t * x.f),
    Law("glue creeps", ACCEL, "plain", lambda x: np.log1p(x.s / 3) * (x.f - x.before)),
    Law("scale with the rate of temperature", ACCEL, "warm", lambda x: x.T_rate * x.f),
    Law("cross-axis with temperature", ACCEL, "warm", lambda x: x.T * turned(x.f, 1)),
    Law("a sag of the supply's sine", ACCEL, "plain", lambda x: phases(TAU * x.t / 450)),
)
