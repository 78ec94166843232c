"""What a hand turn's counts say while it is under way: revolutions, and how far it came back.

A gyro whose axis is vertical counts ``total = k (theta + c) + r T`` in a turn of T seconds: ``theta`` the whole
revolutions, ``c`` the closure, ``r`` its rate at rest in the same place, which is bias and vertical Earth rate in
one. Less ``r T``, the turns + and - about one axis add up to ``k (c+ + c-)`` and differ by ``2 k theta``, so that
their closure is known without k. The first turn of an axis has nothing to add to: its return is read from the
Earth's rate (`procedures.gyrocompass.heading_change`).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Turned:
    """A turn as its vertical gyro counted it: total less the rate at rest [count], and its 1 sigma."""

    counts: float
    std: float


def turned(total: float, seconds: float, rest: float, rest_std: float, noise: float) -> Turned:
    """Take the rate at rest [count/s] off a turn's total [count].

    ``noise`` is the white noise [count/sqrt(s)]; a total is off by two remainders, variance 1/6.
    """
    variance = noise**2 * seconds + 1 / 6 + (rest_std * seconds) ** 2
    return Turned(total - rest * seconds, float(np.sqrt(variance)))


def revolutions(counts: float, k: float) -> float:
    """Return the revolutions, signed as the gyro is, of ``counts`` at a scale factor ``k`` [count/rad]."""
    return counts / (2 * np.pi * k)


def came_back(turn: Turned, opposite: Turned, revolutions: int) -> tuple[float, float]:
    """Return how far the cube is turned after two opposite turns [rad], in the sense of ``turn``, and 1 sigma.

    That is the excess of ``turn`` over its ``revolutions``, less the excess of the opposite one over as many.
    """
    k = (turn.counts - opposite.counts) / (4 * np.pi * revolutions)  # count/rad
    return (turn.counts + opposite.counts) / k, float(np.hypot(turn.std, opposite.std) / abs(k))
