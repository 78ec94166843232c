"""Motion of a log without aid: the settings that its own residual asks for, and the heading at rest.

Without aid the filter measures ``v = 0`` with white noise N. In a hand the velocity is about zero within tenths of
a second: of a spread s and a correlation time t it is white noise of density ``s sqrt(2 t)``, more for what is
moved to and fro than for what is turned in place. In a vehicle it is not: an unknown acceleration continues, and
its velocity stays. The noise density of the velocity over some seconds distinguishes the two, and is N itself
where it does (adaptive estimation from innovations: Mehra 1970).

At rest the Earth's rate gives the heading (gyrocompassing, `procedures.gyrocompass.attitude_at_rest`). Its
level part is Omega cos(lat): the standard deviation of the heading is the gyros' bias over that.
"""

import math

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_filter import start_down
from procedures.attitude.kalman.kalman_filter import AttitudeKalmanFilter
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.sensor_noise import gyro_noise
from procedures.free_positions.rest_detection import second_means
from procedures.geodesy import EARTH_RATE
from procedures.gyrocompass import attitude_at_rest

MIN_MOTION_S = 10.0  # of motion that says something
ROOM_SPEED_NOISE_BOUNDS = 0.11, 0.6  # m/s*sqrt(s)
DRIFT_LIMIT = 1.2  # of the noise that is assumed: beyond, the velocity is no noise about zero
FIRST_SPEED_NOISE = 100.0  # m/s*sqrt(s): 30 m/s that last for five seconds
DRIFT_GAIN = 2.0  # the velocity that the filter lets stand is less than the true one
VEHICLE_SPEED_NOISE_BOUNDS = 5.0, 300.0
WALK_PER_NOISE = 0.4  # 1/s: of a gyro's bias, in motion
BIAS_WALK_BOUNDS = 1e-5, 1e-4  # rad/s/sqrt(s): bounds of that
REST_SIGMAS = 6.0  # what stands still varies by less than so many times its own noise
REST_FORCE_BOUNDS = 0.03, 0.3  # m/s2: bounds of that
REST_RATE_BOUNDS = math.radians(0.1), math.radians(1.0)  # rad/s
VEHICLE_RUNS = 2  # in which its speed settles


def run_unaided(log: AttitudeLog, settings: KalmanSettings) -> tuple[AttitudeKalmanFilter, FloatArray, bool]:
    """Run a log without aid: at once, then with what it showed of its motion.

    Returns
    -------
    filter, out : as of its last run
        ``out`` (n, 4) is that of `AttitudeKalmanFilter.run`.
    is_vehicle
        Whether it went so far that only gyros determine its attitude.
    """
    kept, out = _run(log, settings)
    if moves_far(kept):
        kept, out = _run(log, vehicle_settings(settings))
        for _ in range(VEHICLE_RUNS):
            kept, out = _run(log, settings_in_vehicle(kept))
        return kept, out, True
    if kept.state.memory[0].drift_time >= MIN_MOTION_S:
        kept, out = _run(log, settings_in_hand(kept))
    return kept, out, False


def _run(log: AttitudeLog, settings: KalmanSettings) -> tuple[AttitudeKalmanFilter, FloatArray]:
    kept = AttitudeKalmanFilter("none", settings)
    return kept, kept.run(log)


def drift_density(kept: AttitudeKalmanFilter) -> float:
    """Return the noise density [m/s*sqrt(s)] that the velocity showed over seconds, where nothing rested."""
    memory = kept.state.memory[0]
    return float(np.sqrt(memory.drift_squared / memory.drift_time)) if memory.drift_time > 0.0 else 0.0


def moves_far(kept: AttitudeKalmanFilter) -> bool:
    """Say whether the velocity drifted further than the filter's settings admit."""
    return drift_density(kept) > DRIFT_LIMIT * kept.settings.speed_noise


def settings_in_hand(kept: AttitudeKalmanFilter) -> KalmanSettings:
    """Return a room's settings with the noise of the velocity that it showed: its spread, for a known time."""
    memory = kept.state.memory[0]
    spread = math.sqrt(memory.speed_squared / (3.0 * memory.drift_time))
    noise = spread * math.sqrt(2.0 * kept.settings.speed_s)
    return kept.settings._replace(speed_noise=float(np.clip(noise, *ROOM_SPEED_NOISE_BOUNDS)))


def vehicle_settings(settings: KalmanSettings) -> KalmanSettings:
    """Return settings of a log without aid, with what its unit does at rest filled in, for a vehicle.

    What stands still is judged by the unit's own noise: in a vehicle a slow bend or soft braking looks like rest.
    """
    root = math.sqrt(settings.update_s)
    return settings._replace(
        speed_noise=FIRST_SPEED_NOISE, velocity_std=3.0, gyro_noise=1e-4, gyro_noise_per_rate=3e-3,
        gyro_bias_walk=float(np.clip(WALK_PER_NOISE * settings.rest_gyro_noise, *BIAS_WALK_BOUNDS)),
        force_noise=0.05, cruise_std=0.1, rest_rate_noise=1e-3,
        rest_force=float(np.clip(REST_SIGMAS * settings.rest_force_noise / root, *REST_FORCE_BOUNDS)),
        rest_rate=float(np.clip(REST_SIGMAS * settings.rest_gyro_noise / root, *REST_RATE_BOUNDS)),
    )  # fmt: skip


def settings_in_vehicle(kept: AttitudeKalmanFilter) -> KalmanSettings:
    """Return a vehicle's settings with the speed noise that it showed."""
    shown = DRIFT_GAIN * drift_density(kept)
    return kept.settings._replace(speed_noise=float(np.clip(shown, *VEHICLE_SPEED_NOISE_BOUNDS)))


MIN_REST_S = 30.0
MAX_RATE_CHANGE, MAX_FORCE_CHANGE = np.radians(0.05), 0.05  # rad/s, m/s2: by which a second's mean may stray
MAX_HEADING_STD = np.radians(10.0)  # 1 sigma of a heading that is good for the Earth's rate: a sixth of it is left


def resting_rows(log: AttitudeLog) -> int:
    """Return for how many rows from its start a log stands still, in whole seconds."""
    rows = max(round(1.0 / log.nominal), 1)
    m = len(log.t) // rows
    if m < 2:
        return 0
    second, moved = np.arange(m * rows) // rows, np.zeros(m, bool)
    for values, limit in ((log.omega_b, MAX_RATE_CHANGE), (log.f_b, MAX_FORCE_CHANGE)):
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
