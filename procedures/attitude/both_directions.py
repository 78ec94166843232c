"""Roll and pitch of a log looked at from both ends: for records, not online.

The Kalman filter runs forwards, and backwards from the end; the mean of the two down vectors, each weighted by its
own variance, is the smoothed one (Fraser and Potter 1969). What the two share, the accelerometers' biases, is not
made less by the mean: it stays in sigma.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import AttitudeEstimate, estimate, over_frozen_rows, stamp_sigma
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman_state import KalmanSettings
from procedures.units import STANDARD_GRAVITY

HALF_TURN = np.array([-1.0, -1.0, 1.0])  # about down


def reversed_log(log: AttitudeLog) -> AttitudeLog:
    """Return a log as it would have been recorded with time running backwards; its rows are ends of intervals.

    Row i of the result ends where row n - 1 - i of the log begins. Body and level frame are turned by half a turn
    about down: what flew forwards still does, headings stay, the Earth turns as at the opposite latitude.
    """
    begins = np.concatenate(([log.t[0] - log.nominal], log.t[:-1]))
    return AttitudeLog(
        t=-begins[::-1], omega_b=-HALF_TURN * log.omega_b[::-1], f_b=HALF_TURN * log.f_b[::-1],
        airspeed=None if log.airspeed is None else log.airspeed[::-1].copy(),  # a mean over the interval
        velocity=None if log.velocity is None else -HALF_TURN * _at_ends(log.velocity),
        heading=None if log.heading is None else _at_ends(log.heading),
    )  # fmt: skip


def estimate_both_directions(
    log: AttitudeLog, aid: str, gravity: float = STANDARD_GRAVITY, latitude: float | None = None,
    settings: KalmanSettings | None = None, gyro_bias_std: float | None = None,
    force_bias_std: float | None = None, fix_latency: float = 0.0,
) -> AttitudeEstimate:  # fmt: skip
    """Return roll and pitch along a log by one of the Kalman filter's aids, forwards and backwards.

    Arguments are those of `procedures.attitude.attitude_estimate.estimate`; the gyro bias is that of the end.
    """
    return over_frozen_rows(
        log,
        lambda measured: _both(
            measured, aid, gravity, latitude, settings, gyro_bias_std, force_bias_std, fix_latency
        ),
    )


def _both(
    log: AttitudeLog, aid: str, gravity: float, latitude: float | None, settings: KalmanSettings | None,
    gyro_bias_std: float | None, force_bias_std: float | None, fix_latency: float,
) -> AttitudeEstimate:  # fmt: skip
    given = {"settings": settings, "gyro_bias_std": gyro_bias_std, "force_bias_std": force_bias_std}
    ahead = estimate(log, aid, None, gravity, latitude, fix_latency=fix_latency, **given)  # type: ignore[arg-type]
    back = estimate(
        reversed_log(_fixes_in_time(log, fix_latency)), aid, None, gravity,
        None if latitude is None else -latitude, **given,  # type: ignore[arg-type]
    )  # fmt: skip
    assert ahead.sigma is not None
    assert back.sigma is not None
    later, sigma = ahead.down.copy(), ahead.sigma.copy()
    later[:-1] = HALF_TURN * back.down[::-1][1:]  # the state where the next row begins
    sigma[:-1] = back.sigma[::-1][1:]
    assert ahead.force_bias_std is not None
    bias = np.sqrt(2.0 * np.mean(ahead.force_bias_std**2))  # of two axes
    shared = np.hypot(bias / gravity, stamp_sigma(log, ahead.down))
    down, sigma = _mean(ahead.down, ahead.sigma, later, sigma, shared)
    return replace(ahead, down=down, sigma=sigma)


def _mean(
    a: FloatArray, a_sigma: FloatArray, b: FloatArray, b_sigma: FloatArray, shared: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the weighted mean of two directions (n, 3) and its sigma; ``shared`` (n,) [rad] is one error."""
    weight = a_sigma**-2, b_sigma**-2
    mean = weight[0][:, None] * a + weight[1][:, None] * b
    common = np.minimum(shared, np.minimum(a_sigma, b_sigma)) ** 2
    own = (weight[0] ** 2 * (a_sigma**2 - common) + weight[1] ** 2 * (b_sigma**2 - common)) / sum(weight) ** 2
    return mean / np.linalg.norm(mean, axis=1)[:, None], np.sqrt(own + common)


def _at_ends(values: FloatArray) -> FloatArray:
    """Return what stands at rows' ends in reverse: the end of a row is where the next begins."""
    found: FloatArray = np.full_like(values, np.nan)
    found[:-1] = values[-2::-1]
    return found


def _fixes_in_time(log: AttitudeLog, latency: float) -> AttitudeLog:
    """Put velocities at the rows nearest to their own moments, ``latency`` [s] before those they stand at."""
    if log.velocity is None or latency == 0.0:
        return log
    fixed = np.flatnonzero(np.isfinite(log.velocity).all(axis=1) & (log.t - latency >= log.t[0]))
    rows = np.searchsorted(log.t, log.t[fixed] - latency - 0.5 * log.nominal)
    velocity = np.full_like(log.velocity, np.nan)
    velocity[rows] = log.velocity[fixed]
    return replace(log, velocity=velocity)
