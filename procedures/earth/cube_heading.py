"""Which way a resting cube points, at any angle: the level part of the Earth's rate points North.

A gyro at rest counts ``r = k (u + b)``. Dwells whose position is certain say its bias: ``r / k - u`` is b, each
to within its noise and what `procedures.earth.gyrocompass` grants to scale factors that differ and cubes a degree
off; b has its normal prior besides. What is left of the rate in question, in the slab's axes as the cube is
thought to stand, should be the Earth's ``(0, W cos lat, W sin lat)``: the angle from its level part to North is
how far the cube's heading is off. Where the parts are not as long as the Earth's, it is not the Earth's rate that
was seen.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.gravity_and_rate import EARTH_RATE, earth_rate_n
from procedures.earth.gyrocompass import (
    BIAS_STD_RAD_S,
    EARTH_RATE_SLACK,
    SCALE_SPREAD,
    CertainDwell,
    earth_rate_at,
)

MAX_EARTH_RATE_SIGMAS = 4.0  # sigma


def earth_heading(
    rate: FloatArray, std: FloatArray, C_lb: FloatArray, latitude: float, C_sb: FloatArray, k: float,
    known: Sequence[CertainDwell] = (),
) -> tuple[float, float]:  # fmt: skip
    """Return how far the cube's heading is off [rad], counter-clockwise seen from above, and 1 sigma.

    Turned so far it points as ``C_lb`` says. The sigma is infinite where the rate is not the Earth's.

    Parameters
    ----------
    rate, std : (3,) float64, count/s
        The gyros at rest, IMU axes, raw, with 1 sigma.
    C_lb : (3, 3), the cube's axes to East, North, Up, right but for the heading
    latitude : rad
    C_sb : (3, 3), takes the cube's axes to the IMU's
    k : the gyros' scale factor [count/rad]
    known : dwells of this unit, since it was switched on, whose position is certain
    """
    bias, bias_var = _bias(latitude, C_sb, k, known)
    variance = (
        (std / k) ** 2 + bias_var + (EARTH_RATE_SLACK * EARTH_RATE) ** 2 + (SCALE_SPREAD * (rate / k - bias)) ** 2
    )
    seen, seen_var = C_lb @ C_sb.T @ (rate / k - bias), (C_lb @ C_sb.T) ** 2 @ variance
    earth = earth_rate_n(latitude)
    level = float(np.hypot(seen[0], seen[1]))
    level_std = float(np.sqrt(max(seen_var[:2])))
    is_earth = abs(level - earth[1]) < MAX_EARTH_RATE_SIGMAS * level_std and abs(
        seen[2] - earth[2]
    ) < MAX_EARTH_RATE_SIGMAS * np.sqrt(seen_var[2])
    if not is_earth or not earth[1] > 0:
        return 0.0, np.inf
    return float(np.arctan2(seen[0], seen[1])), level_std / float(earth[1])


def _bias(
    latitude: float, C_sb: FloatArray, k: float, known: Sequence[CertainDwell]
) -> tuple[FloatArray, FloatArray]:
    """Return the gyros' biases (3,) [rad/s] and their variances (3,)."""
    weight, total = np.full(3, BIAS_STD_RAD_S**-2), np.zeros(3)
    for each in known:
        u = earth_rate_at(each.position, latitude, C_sb)
        of_dwell = 1 / ((each.std / k) ** 2 + (EARTH_RATE_SLACK * EARTH_RATE) ** 2 + (SCALE_SPREAD * u) ** 2)
        weight, total = weight + of_dwell, total + of_dwell * (each.rate / k - u)
    return total / weight, 1 / weight
