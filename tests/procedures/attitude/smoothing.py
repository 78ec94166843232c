"""A log looked at from both ends: for records, not online.

The Kalman filter runs forwards, and backwards from the end with the rates turned round; the mean of the two down
vectors, each weighted by its own variance, is the smoothed one. Errors of the two have little in common but the
sensors' biases.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman_state import KalmanSettings


def reversed_log(log: AttitudeLog) -> AttitudeLog:
    """Return a log as it would have been recorded with time running backwards; its rows are ends of intervals.

    Row i of the result ends where row n - 1 - i of the log begins. Aids of velocity change sign, headings do not.
    """
    begins = np.concatenate(([log.t[0] - log.nominal], log.t[:-1]))
    return AttitudeLog(
        t=-begins[::-1], omega_b=-log.omega_b[::-1], f_b=log.f_b[::-1].copy(),
        airspeed=None if log.airspeed is None else -log.airspeed[::-1],
        velocity=None if log.velocity is None else -log.velocity[::-1],
        heading=None if log.heading is None else log.heading[::-1].copy(),
    )  # fmt: skip


def smooth(log: AttitudeLog, aid: str = "none", settings: KalmanSettings | None = None) -> FloatArray:
    """Return the smoothed down vector (n, 3) of every row of a log by one of the Kalman filter's aids."""
    forward, back = (estimate(each, aid, settings=settings) for each in (log, reversed_log(log)))
    assert forward.sigma is not None
    assert back.sigma is not None
    later, sigma = forward.down.copy(), forward.sigma.copy()
    later[:-1], sigma[:-1] = back.down[::-1][1:], back.sigma[::-1][1:]  # the state where the next row begins
    weight = (forward.sigma**-2)[:, None], (sigma**-2)[:, None]
    mean = weight[0] * forward.down + weight[1] * later
    found: FloatArray = mean / np.linalg.norm(mean, axis=1)[:, None]
    return found
