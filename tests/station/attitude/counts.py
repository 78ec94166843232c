"""Counts of a calibrated unit as the attitude algorithms take them: `calibration/1` applied, axes turned."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.counts.sample_times import GAP_PERIODS
from procedures.units import STANDARD_GRAVITY
from station.calibrated.calibration_applied import calibrated_inputs
from station.calibrated.surroundings import Surroundings

UNKNOWN = Surroundings()
FORWARD_LEFT_UP = np.diag([1.0, -1.0, -1.0])  # IMU x forward, y left, z up: what forward-right-down sees of it


def log_of_counts(
    calibration: Mapping[str, Any], t: FloatArray, gyro: FloatArray, accel: FloatArray,
    around: Surroundings = UNKNOWN, C_frd: FloatArray = FORWARD_LEFT_UP,
) -> tuple[AttitudeLog, tuple[str, ...]]:  # fmt: skip
    """Return increments of counts as an attitude log, and what is said of effects that were left in.

    Parameters
    ----------
    t : (n,) s
        End of each sample.
    gyro, accel : (n, 3)
        Counts since the sample before. Over a gap the first sample after it holds one interval's counts.
    C_frd : (3, 3)
        Takes IMU axes to forward-right-down.
    """
    nominal = float(np.median(np.diff(t)))
    interval = np.diff(t, prepend=t[0] - nominal)
    interval = np.where(interval > GAP_PERIODS * nominal, nominal, interval)
    seen = calibrated_inputs(calibration, accel / interval[:, None], gyro / interval[:, None], around)
    if seen.f is None or seen.omega is None:
        raise ValueError("the calibration holds one triad, expected accelerometer and gyroscope")
    rate = np.radians(seen.omega) @ C_frd.T
    return AttitudeLog(t, rate, STANDARD_GRAVITY * seen.f @ C_frd.T), seen.not_applied
