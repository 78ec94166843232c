"""What an alignment gives, or why there is none yet."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

SETTLED_YAW = np.radians(4.0)  # 1 sigma with which an alignment is accepted
SETTLED_TILT = np.radians(1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Aligned:
    """State at the first of the fixes ``t0``: ``C_nb``, ``v_n`` and biases with covariance (12, 12) or (15, 15).

    In the order rotation about n [rad], v [m/s], gyro bias [rad/s], accelerometer bias [m/s2], and ``lever`` (3,)
    [m] in b, the antenna's, where it was estimated. ``C_now`` is the attitude at the last fix, ``tilt_std`` and
    ``yaw_std`` [rad] 1 sigma of it.
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


@dataclass(frozen=True, slots=True, eq=False)
class Waiting:
    """Why there is no alignment yet."""

    why: str
