"""What the Kalman filter assumes of the unit at hand: from its own noise, its calibration's sigma, and the Earth.

The filter's own settings are for any IMU, MEMS ones too. A calibrated FOG's biases hardly drift and its scale
factors are known, so that its gyros may be believed for much longer.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from procedures.attitude.attitude_log import AttitudeLog, earth_rate_ned
from procedures.attitude.kalman.kalman_settings import AIDED_SETTINGS, UNAIDED_SETTINGS, KalmanSettings
from procedures.attitude.kalman.unaided_motion import vehicle_settings
from procedures.attitude.sensor_noise import gyro_noise, white_noise
from procedures.geodesy import EARTH_RATE
from procedures.units import DEG_H_PER_DEG_S, RAD_S_PER_DEG_H, STANDARD_GRAVITY

MIN_GYRO_NOISE = 1e-7  # rad/sqrt(s)
TURN_ON = RAD_S_PER_DEG_H  # what a FOG's bias differs by from its calibration, standard uncertainty
GYRO_BIAS_WALK = 1e-6  # rad/s/sqrt(s), of a FOG's bias
FORCE_WALK = 1e-6  # m/s2/sqrt(s)
RESTING_VELOCITY = 1e-3  # m/s*sqrt(s)
QUANTISATION_STD = 12**-0.5  # sqrt(s): evenly within a count's worth of velocity, for about a second
RESTING_FORCE = 2e-4  # m/s/sqrt(s): a bench is never quite quiet


def filter_settings(
    calibration: Mapping[str, Any] | None, aid: str, log: AttitudeLog, gravity: float, latitude: float | None,
    knows_heading: bool, quantum: float = 0.0,
) -> KalmanSettings:  # fmt: skip
    """Return the filter's settings.

    ``log`` are the first seconds, ``latitude`` [rad] or None if not known, ``quantum`` [m/s2] a count's worth of a
    sample's specific force.
    """
    knows_earth = latitude is not None and knows_heading
    earth = np.zeros(3) if latitude is None else earth_rate_ned(latitude)
    noise = max(gyro_noise(log), MIN_GYRO_NOISE)
    base = (UNAIDED_SETTINGS if aid == "none" else AIDED_SETTINGS)._replace(
        gravity=gravity, nominal_s=log.nominal, gyro_noise=noise,
        earth_north=float(earth[0]), earth_down=float(earth[2]),
    )  # fmt: skip
    if calibration is None:
        return base._replace(gyro_bias_std=float(np.hypot(base.gyro_bias_std, EARTH_RATE)))
    gyro = calibration["gyroscope"]
    scale = _relative(gyro["scale_factor"]) + _largest(gyro["misalignment"])
    bias = gyro_bias_std(calibration)
    return base._replace(
        gyro_bias_std=float(np.hypot(bias, 0.0 if knows_earth else EARTH_RATE)),
        gyro_bias_walk=GYRO_BIAS_WALK, rest_bias_walk=GYRO_BIAS_WALK,
        unseen_rate=0.0 if knows_earth else EARTH_RATE,
        gyro_scale_std=max(scale, 1e-5), gyro_noise_per_rate=max(scale, 1e-4),
        force_bias_std=max(force_bias_std(calibration), 1e-5), force_bias_walk=FORCE_WALK,
        rest_force_noise=max(white_noise(log.f_b, log.nominal, window_s=np.inf, quantum=quantum), RESTING_FORCE),
        rest_velocity_noise=max(RESTING_VELOCITY, QUANTISATION_STD * quantum * log.nominal),
    )  # fmt: skip


def in_a_vehicle(settings: KalmanSettings, calibration: Mapping[str, Any] | None) -> KalmanSettings:
    """Return a room's settings as a vehicle's; what a calibration says of the gyros stands."""
    found = vehicle_settings(settings._replace(rest_gyro_noise=settings.gyro_noise))
    if calibration is None:
        return found
    return found._replace(gyro_noise_per_rate=settings.gyro_noise_per_rate, gyro_bias_walk=settings.gyro_bias_walk)


def gyro_bias_std(calibration: Mapping[str, Any]) -> float:
    """Return the standard uncertainty [rad/s] of a calibrated gyro's bias on another day."""
    return float(np.hypot(np.radians(_largest(calibration["gyroscope"]["bias"])) / DEG_H_PER_DEG_S, TURN_ON))


def force_bias_std(calibration: Mapping[str, Any]) -> float:
    """Return the standard uncertainty [m/s2] across gravity of a calibrated accelerometer: its axes' rms.

    A scale factor shows most at 45 deg, by half of its error.
    """
    accel = calibration["accelerometer"]
    names = ("bias", "scale_factor", "misalignment")
    bias, scale, turned = (np.array(accel[name]["std"], dtype=np.float64) for name in names)
    relative = scale / np.array(accel["scale_factor"]["value"], dtype=np.float64)
    six = np.nansum(turned**2) / 6  # off the diagonal; the rest follows from the rows' unit length
    return STANDARD_GRAVITY * float(np.sqrt(np.nanmean(bias**2) + 0.25 * np.nanmean(relative**2) + six))


def _largest(part: Mapping[str, Any]) -> float:
    return float(np.nanmax(np.abs(np.array(part["std"], dtype=np.float64))))


def _relative(part: Mapping[str, Any]) -> float:
    std, value = (np.array(part[name], dtype=np.float64) for name in ("std", "value"))
    return float(np.nanmax(np.abs(std / value)))
