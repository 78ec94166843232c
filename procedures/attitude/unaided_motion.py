"""How a log without aid moves: told by its own residual, and filtered with settings that admit it.

Without aid the filter measures ``v = 0`` with white noise N. In a hand the velocity is about zero within tenths of
a second: of a spread s and a correlation time t it is white noise of density ``s sqrt(2 t)``, more for what is
moved to and fro than for what is turned in place. In a vehicle it is not: an acceleration that is not known goes
on, and its velocity stays. The noise density that the velocity shows over some seconds tells the two apart, and is
N itself where it does (adaptive estimation from innovations: Mehra 1970).
"""

import math

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman_state import KalmanSettings
from procedures.attitude.roll_pitch_kalman_filter import AttitudeKalmanFilter

LEAST_MOTION_S = 10.0  # of motion that says something
ROOM_SPEED_NOISE = 0.11, 0.6  # m/s*sqrt(s)
WANDER_LIMIT = 1.2  # of the noise that is assumed: beyond, the velocity is no noise about zero
FIRST_SPEED_NOISE = 100.0  # m/s*sqrt(s): 30 m/s that last for five seconds
WANDER_GAIN = 2.0  # the velocity that the filter lets stand is less than the true one
VEHICLE_SPEED_NOISE = 5.0, 300.0
WALK_PER_NOISE = 0.4  # 1/s: of a gyro's bias, in motion
BIAS_WALK = 1e-5, 1e-4  # rad/s/sqrt(s): bounds of that
STILL_SIGMA = 6.0  # what stands still varies by less than so many times its own noise
STILL_FORCE = 0.03, 0.3  # m/s2: bounds of that
STILL_RATE = math.radians(0.1), math.radians(1.0)  # rad/s
VEHICLE_RUNS = 2  # in which its speed settles


def run_as_it_moves(log: AttitudeLog, settings: KalmanSettings) -> tuple[AttitudeKalmanFilter, FloatArray, bool]:
    """Run a log without aid: at once, then with what it showed of its motion.

    Returns
    -------
    filter, out : as of its last run
        ``out`` (n, 4) is that of `AttitudeKalmanFilter.run`.
    is_vehicle
        Whether it went so far that only gyros tell its attitude.
    """
    kept, out = _run(log, settings)
    if moves_far(kept):
        kept, out = _run(log, vehicle_settings(settings))
        for _ in range(VEHICLE_RUNS):
            kept, out = _run(log, with_own_speed(kept))
        return kept, out, True
    if kept.state.memory[0].wander_time >= LEAST_MOTION_S:
        kept, out = _run(log, with_own_spread(kept))
    return kept, out, False


def _run(log: AttitudeLog, settings: KalmanSettings) -> tuple[AttitudeKalmanFilter, FloatArray]:
    kept = AttitudeKalmanFilter("none", settings)
    return kept, kept.run(log)


def wander_density(kept: AttitudeKalmanFilter) -> float:
    """Return the noise density [m/s*sqrt(s)] that the velocity showed over seconds, where nothing rested."""
    memory = kept.state.memory[0]
    return float(np.sqrt(memory.wander_squared / memory.wander_time)) if memory.wander_time > 0.0 else 0.0


def moves_far(kept: AttitudeKalmanFilter) -> bool:
    """Say whether the velocity wandered further than the filter's settings admit."""
    return wander_density(kept) > WANDER_LIMIT * kept.settings.speed_noise


def with_own_spread(kept: AttitudeKalmanFilter) -> KalmanSettings:
    """Return a room's settings with the noise of the velocity that it showed: its spread, for a known time."""
    memory = kept.state.memory[0]
    spread = math.sqrt(memory.speed_squared / (3.0 * memory.wander_time))
    noise = spread * math.sqrt(2.0 * kept.settings.speed_s)
    return kept.settings._replace(speed_noise=float(np.clip(noise, *ROOM_SPEED_NOISE)))


def vehicle_settings(settings: KalmanSettings) -> KalmanSettings:
    """Return settings of a log without aid, with what its unit does at rest filled in, for a vehicle.

    The gyros are believed for minutes, within scale and axes of a MEMS one; the velocity hardly says anything.
    What stands still is judged by the unit's own noise: in a vehicle a slow bend or soft braking looks like rest.
    """
    root = math.sqrt(settings.update_s)
    return settings._replace(
        speed_noise=FIRST_SPEED_NOISE, velocity_std=3.0, gyro_noise=1e-4, gyro_noise_per_rate=3e-3,
        gyro_bias_walk=float(np.clip(WALK_PER_NOISE * settings.rest_gyro_noise, *BIAS_WALK)),
        force_noise=0.05, cruise_std=0.1, rest_rate_noise=1e-3,
        rest_force=float(np.clip(STILL_SIGMA * settings.rest_force_noise / root, *STILL_FORCE)),
        rest_rate=float(np.clip(STILL_SIGMA * settings.rest_gyro_noise / root, *STILL_RATE)),
    )  # fmt: skip


def with_own_speed(kept: AttitudeKalmanFilter) -> KalmanSettings:
    """Return a vehicle's settings with the speed noise that it showed."""
    shown = WANDER_GAIN * wander_density(kept)
    return kept.settings._replace(speed_noise=float(np.clip(shown, *VEHICLE_SPEED_NOISE)))
