"""What an alignment gives, or why there is none yet."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

MAX_YAW_STD = np.radians(4.0)  # 1 sigma with which an alignment is accepted
MAX_TILT_STD = np.radians(1.0)
MAX_TIME_OFFSET_STD_S = 0.015  # s, of GNSS's stamps where it is estimated: a window is built on it


@dataclass(frozen=True, slots=True, eq=False)
class AlignmentState:
    """State at the first of the fixes ``t0``: ``C_nb``, ``v_n``, biases and constants with covariance.

    In the order rotation about n [rad], v [m/s], gyro bias [rad/s], accelerometer bias [m/s2]: (12, 12). In motion
    ``lever`` (3,) [m] in b, the antenna's, and ``time_offset`` [s], to be added to the stamps of fixes, follow:
    (16, 16), 0 where they were given; ``t0`` and ``t`` hold that offset. ``C_now`` is the attitude at the
    last fix, ``tilt_std`` and ``yaw_std`` [rad] 1 sigma of it.
    """

    t0: float
    C_nb: FloatArray
    v_n: FloatArray
    gyro_bias: FloatArray
    accel_bias: FloatArray
    covariance: FloatArray
    t: float
    C_now: FloatArray
    tilt_std: float
    yaw_std: float
    misfit: float
    lever: FloatArray | None = None
    time_offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Waiting:
    """Why there is no alignment yet."""

    why: str
