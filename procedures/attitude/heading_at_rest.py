"""Gyrocompassing at rest: the heading of a unit that stands still, from the Earth's rate that its gyros see.

The attitude is `procedures.earth.gyrocompass.attitude_at_rest`. The Earth's rate has a level part Omega cos(lat):
what the gyros' biases may add to it, over its size, is the sigma of the heading.
"""

import numpy as np

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_filter import start_down
from procedures.attitude.sensor_noise import gyro_noise
from procedures.earth.geodesy import EARTH_RATE
from procedures.earth.gyrocompass import attitude_at_rest
from procedures.free_positions.rest_detection import second_means

MIN_REST_S = 30.0
STILL_RATE, STILL_FORCE = np.radians(0.05), 0.05  # rad/s, m/s2: by which a second's mean may stray
MAX_HEADING_STD = np.radians(10.0)  # 1 sigma of a heading that is good for the Earth's rate: a sixth of it is left


def resting_rows(log: AttitudeLog) -> int:
    """Return for how many rows from its start a log stands still, in whole seconds."""
    rows = max(round(1.0 / log.nominal), 1)
    m = len(log.t) // rows
    if m < 2:
        return 0
    second, moved = np.arange(m * rows) // rows, np.zeros(m, bool)
    for values, limit in ((log.omega_b, STILL_RATE), (log.f_b, STILL_FORCE)):
        means = second_means(second, values[: m * rows])
        moved |= (np.abs(means - means[0]) > limit).any(axis=1)
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
    if n * log.nominal < MIN_REST_S:
        return None
    down = start_down(log.f_b[:n].mean(axis=0))
    C_nb = attitude_at_rest(-down, log.omega_b[:n].mean(axis=0))
    noise = gyro_noise(log) / np.sqrt(n * log.nominal)
    std = float(np.hypot(gyro_bias_std, noise) / (EARTH_RATE * np.cos(latitude)))
    if std > MAX_HEADING_STD or abs(down[0]) > 0.98 or C_nb is None:  # body x upright has no heading
        return None
    return float(np.arctan2(C_nb[0, 0], C_nb[1, 0])), std
