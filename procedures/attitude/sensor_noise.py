"""What a log tells about its sensors: their own noise, the gate above it, the range at which they clip."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_filter import RATE_GATE
from procedures.attitude.complementary_velocity_aids import SMOOTH_S
from procedures.attitude.frozen_rows import noise_above_resolution
from procedures.attitude.kalman_state import KalmanSettings
from procedures.statistics.white_noise import white_noise

GATE_SIGMA = 4.0
MIN_RANGE = np.radians(90.0), 15.0  # rad/s, m/s2: below, only a channel whose noise is seen is said to clip
CLIPPED_ROWS = 3
MIN_GYRO_NOISE = 1e-7  # rad/sqrt(s)
MIN_BIAS_WALK = 3e-6  # rad/s/sqrt(s), of a FOG's bias: three times what it does
WALK_PER_NOISE = 1.0  # 1/s
MIN_REST_FORCE_NOISE = 2e-4  # m/s/sqrt(s): a bench is never quite quiet


def gyro_noise(log: AttitudeLog) -> float:
    """Return the gyros' white noise [rad/sqrt(s)]."""
    return white_noise(log.omega_b, log.nominal)


def at_rest(settings: KalmanSettings, log: AttitudeLog) -> KalmanSettings:
    """Return the Kalman filter's settings with what this unit does at rest: its own noise, and a walk beside it.

    The walk of a bias is far less by the Allan deviation of any gyro; but a rest is never quite one.
    """
    gyro = max(gyro_noise(log), MIN_GYRO_NOISE)
    return settings._replace(
        rest_gyro_noise=gyro,
        rest_bias_walk=min(max(WALK_PER_NOISE * gyro, MIN_BIAS_WALK), settings.rest_bias_walk),
        rest_force_noise=max(white_noise(log.f_b, log.nominal), MIN_REST_FORCE_NOISE),
    )  # fmt: skip


def gate_of(noise: float) -> float:
    """Return the rate [rad/s] above which a unit of this noise [rad/sqrt(s)] turns: never below `RATE_GATE`."""
    return max(RATE_GATE, float(GATE_SIGMA * noise / np.sqrt(2 * SMOOTH_S)))


def range_limit(samples: FloatArray, least: float) -> float:
    """Return the value at which samples (n, 3), of any unit, clip; infinity where they do not.

    They clip where the largest size, above ``least`` or in a channel of more noise than
    resolution, stands for `CLIPPED_ROWS` rows running in a channel.
    """
    top = float(np.abs(samples).max(initial=0.0))
    at_top = np.abs(samples) >= top
    running = at_top[2:] & at_top[1:-1] & at_top[:-2]
    if not running.any():
        return float("inf")
    clips = running.any(axis=0)
    is_sure = top > least or any(np.isfinite(noise_above_resolution(x)) for x in samples.T[clips])
    return top if is_sure else float("inf")


def clipped_rows(log: AttitudeLog) -> tuple[float, float, int]:
    """Return the ranges of gyros [rad/s] and accelerometers [m/s2], infinity where unseen, and the rows at one."""
    rate, force = range_limit(log.omega_b, MIN_RANGE[0]), range_limit(log.f_b, MIN_RANGE[1])
    at_limit = (np.abs(log.omega_b) >= rate).any(axis=1) | (np.abs(log.f_b) >= force).any(axis=1)
    return rate, force, int(at_limit.sum())
