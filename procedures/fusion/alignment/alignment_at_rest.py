"""Attitude at rest: level by specific force, heading by the Earth's rate (gyrocompassing).

The attitude is `procedures.earth.gyrocompass.attitude_at_rest` of the means. What remains is the gyro's bias East
of the horizontal Earth rate, ``yaw_std = bias_std / (Omega cos lat)``, 0.33 deg for 0.05 deg/h at 55 deg, and
``tilt_std = accel_bias / g``.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.gyrocompass import attitude_at_rest
from procedures.free_positions.rest_detection import second_means, whole_seconds
from procedures.fusion.alignment.alignment_result import MAX_TILT_STD, MAX_YAW_STD, AlignmentState, Waiting
from procedures.fusion.fusion_records import ImuNoise, ImuSeries

MAX_FORCE_CHANGE = 5e-3  # m/s2 of a second's mean specific force, beside its noise, that a bench may have
MAX_RATE_CHANGE = 1e-4  # rad/s of a second's mean rate
STILLNESS_SIGMAS = 5.0
MIN_REST_S = 5.0  # s


def is_still(imu: ImuSeries, noise: ImuNoise) -> bool:
    """Say whether second by second specific force and rate stay what they were, but for their noise."""
    second = whole_seconds(imu.t)
    count = np.bincount(second)
    full = count >= 0.5 * np.median(count)
    triads = ((imu.f_b, noise.accel, MAX_FORCE_CHANGE), (imu.omega_b, noise.gyro, MAX_RATE_CHANGE))
    for values, density, allowed in triads:
        means = second_means(second, values)[full]
        if np.abs(means - np.median(means, axis=0)).max() > STILLNESS_SIGMAS * np.hypot(density, allowed):
            return False
    return True


def align_at_rest(
    imu: ImuSeries, noise: ImuNoise, gravity: float, earth_n: FloatArray
) -> AlignmentState | Waiting:
    """Align by the means over all samples and Earth's rate ``earth_n`` (3,) [rad/s], or say what is missing."""
    elapsed = float(imu.t[-1] - imu.t[0])
    if elapsed < MIN_REST_S or not is_still(imu, noise):
        return Waiting(f"it does not stand still for {MIN_REST_S:g} s")
    f, omega = imu.f_b.mean(axis=0), imu.omega_b.mean(axis=0)
    C_nb, horizontal = attitude_at_rest(f, omega), float(earth_n[1])
    rate_std = np.hypot(noise.gyro_bias, noise.gyro / np.sqrt(elapsed))
    yaw_std = float(rate_std / max(horizontal, 1e-12))
    tilt_std = float(np.hypot(noise.accel_bias, noise.accel / np.sqrt(elapsed)) / gravity)
    if yaw_std > MAX_YAW_STD or tilt_std > MAX_TILT_STD or C_nb is None:
        tilt, yaw, tilt_asked, yaw_asked = np.degrees(
            np.minimum([tilt_std, yaw_std, MAX_TILT_STD, MAX_YAW_STD], np.pi)
        )
        return Waiting(
            f"at rest the Earth's rate gives yaw to {yaw:.1f} deg and gravity tilt to {tilt:.1f} deg (u), "
            f"{yaw_asked:.0f} and {tilt_asked:.0f} are needed: move it, or use better gyros"
        )
    std = np.r_[tilt_std, tilt_std, yaw_std, [1e-3] * 3, [rate_std] * 3, [noise.accel_bias] * 3]
    zero = np.zeros(3)
    return AlignmentState(
        float(imu.t[0]), C_nb, zero, zero, zero, np.diag(std**2), float(imu.t[-1]), C_nb, tilt_std, yaw_std, 1.0
    )
