"""Gyrocompassing at rest: the heading of a unit that stands still, from the Earth's rate that its gyros see.

At rest the gyros of a calibrated unit read the Earth's rate. Its part across the down vector points to true north
and is Omega cos(lat): what the gyros' biases may add to that, over its size, is the sigma of the heading.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.mixer import start_down
from procedures.attitude.sensor_noise import gyro_noise
from procedures.earth.gravity_and_rate import EARTH_RATE

LEAST_S = 30.0
STILL_RATE, STILL_FORCE = np.radians(0.05), 0.05  # rad/s, m/s2: by which a second's mean may stray
SURE = np.radians(10.0)  # 1 sigma of a heading that is good for the Earth's rate: a sixth of it is left


def resting_rows(log: AttitudeLog) -> int:
    """Return for how many rows from its start a log stands still, in whole seconds."""
    rows = max(round(1.0 / log.nominal), 1)
    m = len(log.t) // rows
    if m < 2:
        return 0
    seconds = (values[: m * rows].reshape(m, rows, 3).mean(axis=1) for values in (log.rate, log.force))
    moved = np.zeros(m, bool)
    for mean, limit in zip(seconds, (STILL_RATE, STILL_FORCE), strict=True):
        moved |= (np.abs(mean - mean[0]) > limit).any(axis=1)
    first = int(np.argmax(moved)) if moved.any() else m
    return first * rows


def heading_at_rest(log: AttitudeLog, latitude: float, gyro_bias_std: float) -> tuple[float, float] | None:
    """Return heading and 1 sigma [rad] of the rest that a log begins with; None where they say too little.

    Parameters
    ----------
    latitude : rad
    gyro_bias_std : rad/s
        1 sigma of each gyro's bias, after calibration.
    """
    n = resting_rows(log)
    if n * log.nominal < LEAST_S:
        return None
    down = start_down(log.force[:n].mean(axis=0))
    rate = log.rate[:n].mean(axis=0)
    level = rate - down * (down @ rate)
    noise = gyro_noise(log) / np.sqrt(n * log.nominal)
    std = float(np.hypot(gyro_bias_std, noise) / (EARTH_RATE * np.cos(latitude)))
    if std > SURE or abs(down[0]) > 0.98:  # body x upright has no heading
        return None
    return float(np.arctan2(-_east(down, level), level @ _forward(down))), std


def _forward(down: FloatArray) -> FloatArray:
    """Return the level direction (3,) of body x."""
    x = np.array([1.0, 0.0, 0.0]) - down[0] * down
    forward: FloatArray = x / np.linalg.norm(x)
    return forward


def _east(down: FloatArray, north: FloatArray) -> float:
    """Return the component of a level vector to the right of body x."""
    return float(north @ np.cross(down, _forward(down)))
