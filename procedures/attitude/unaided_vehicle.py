"""A vehicle without aid: told by its own residual, and filtered with settings that admit what it does.

Without aid the filter measures ``v = 0`` with white noise N. In a room what is left of the velocity averages out
in seconds. In a vehicle it does not: an acceleration that is not known goes on, and its velocity stays. The noise
density that the velocity shows over some seconds tells the two apart, and is N itself where it does (adaptive
estimation from innovations: Mehra 1970).
"""

import numpy as np

from procedures.attitude.kalman_state import KalmanSettings
from procedures.attitude.roll_pitch_kalman_filter import AttitudeKalmanFilter

WANDER_LIMIT = 1.2  # of the noise that is assumed: beyond, the velocity is no noise about zero
FIRST_SPEED_NOISE = 100.0  # m/s*sqrt(s): 30 m/s that last for five seconds
WANDER_GAIN = 2.0  # the velocity that the filter lets stand is less than the true one
LEAST_SPEED_NOISE, MOST_SPEED_NOISE = 5.0, 300.0
WALK_PER_NOISE = 0.4  # 1/s: of a gyro's bias, in motion
LEAST_WALK, MOST_WALK = 1e-5, 1e-4  # rad/s/sqrt(s)
STILL_SIGMA = 6.0  # what stands still varies by less than so many times its own noise
STILL_FORCE = 0.03, 0.3  # m/s2: bounds of that
STILL_RATE = np.radians(0.1), np.radians(1.0)  # rad/s


def wander_density(kept: AttitudeKalmanFilter) -> float:
    """Return the noise density [m/s*sqrt(s)] that the velocity showed over seconds, where nothing rested."""
    memory = kept.state.memory[0]
    return float(np.sqrt(memory.wander_squared / memory.wander_time)) if memory.wander_time > 0.0 else 0.0


def moves_far(kept: AttitudeKalmanFilter) -> bool:
    """Say whether the velocity wandered further than the filter's settings admit."""
    return wander_density(kept) > WANDER_LIMIT * kept.settings.speed_noise


def vehicle_settings(settings: KalmanSettings) -> KalmanSettings:
    """Return settings of a log without aid, with what its unit does at rest filled in, for a vehicle.

    The gyros are believed for minutes, within scale and axes of a MEMS one; the velocity hardly says anything.
    What stands still is judged by the unit's own noise: in a vehicle a slow bend or soft braking looks like rest.
    """
    root = np.sqrt(settings.update_s)
    return settings._replace(
        speed_noise=FIRST_SPEED_NOISE, velocity_std=3.0, gyro_noise=1e-4, gyro_noise_per_rate=3e-3,
        gyro_bias_walk=float(np.clip(WALK_PER_NOISE * settings.rest_gyro_noise, LEAST_WALK, MOST_WALK)),
        force_noise=0.05, cruise_std=0.1, rest_rate_noise=1e-3,
        rest_force=float(np.clip(STILL_SIGMA * settings.rest_force_noise / root, *STILL_FORCE)),
        rest_rate=float(np.clip(STILL_SIGMA * settings.rest_gyro_noise / root, *STILL_RATE)),
    )  # fmt: skip


def with_own_speed(kept: AttitudeKalmanFilter) -> KalmanSettings:
    """Return a vehicle's settings with the speed noise that it showed."""
    shown = WANDER_GAIN * wander_density(kept)
    return kept.settings._replace(speed_noise=float(np.clip(shown, LEAST_SPEED_NOISE, MOST_SPEED_NOISE)))
