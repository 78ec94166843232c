"""The Kalman filter of attitude, velocity and biases: the default of every aid.

One error-state filter; only the velocity measurement changes with the aid. Attitude error and velocity share one
covariance, which is what You and Lee's velocity filter lacks: there the error of attitude is taken for velocity,
and in a turn beyond a minute the two feed each other.
"""

from copy import copy

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman_kernels import AIRSPEED, GNSS, NO_AID, advance, filter_log
from procedures.attitude.kalman_state import AIDED_SETTINGS, KalmanSettings, new_state

AID_CODE = {"none": NO_AID, "airspeed-filter": AIRSPEED, "gnss": GNSS}
NO_VELOCITY = np.full(3, np.nan)


class AttitudeKalmanFilter:
    """Attitude of one sample after another; nothing is kept but the state.

    ``aid`` is one of `AID_CODE`. The first sample's specific force is taken for the vertical, within
    ``settings.tilt_std``; a gap of 5 s, of less while it turns fast, begins anew with the
    biases that were learned.
    """

    def __init__(self, aid: str = "none", settings: KalmanSettings = AIDED_SETTINGS) -> None:
        self.aid, self.settings = AID_CODE[aid], settings
        self.state = new_state(self.aid == AIRSPEED)
        self._t: float | None = None

    def step(
        self, t: float, omega_b: FloatArray, f_b: FloatArray, airspeed: float = np.nan,
        velocity: FloatArray = NO_VELOCITY, heading: float = np.nan,
    ) -> FloatArray:  # fmt: skip
        """Take the sample that ends at ``t`` [s] and return the down vector (3,) there.

        Parameters
        ----------
        omega_b, f_b : (3,), rad/s, m/s2
        velocity : (3,), m/s, north-east-down
            Nan where there is none, as are ``airspeed`` [m/s] and ``heading`` [rad], true.
        """
        dt = self.settings.nominal_s if self._t is None else t - self._t
        self._t = t
        advance(self.state, self.settings, self.aid, dt, omega_b, f_b, airspeed, velocity, heading)
        return self.down

    def run(self, log: AttitudeLog) -> FloatArray:
        """Take a whole log: the down vector and its sigma [rad] of every row, (n, 4)."""
        n = len(log.t)
        out, none = np.empty((n, 4)), np.full(n, np.nan)
        dt = log.intervals
        if self._t is not None:
            dt[0] = log.t[0] - self._t
        filter_log(
            self.state, self.settings, self.aid, dt, log.omega_b, log.f_b,
            none if log.airspeed is None else log.airspeed,
            np.broadcast_to(NO_VELOCITY, (n, 3)).copy() if log.velocity is None else log.velocity,
            none if log.heading is None else log.heading, out,
        )  # fmt: skip
        self._t = float(log.t[-1])
        return out

    def copy(self) -> "AttitudeKalmanFilter":
        """Return another that goes on from here."""
        other = copy(self)
        other.state = new_state(self.aid == AIRSPEED)
        for mine, its in zip(self.state, other.state, strict=True):
            its[...] = mine
        return other

    def forget_motion(self) -> None:
        """Begin the sums anew of how the velocity moves about zero."""
        memory = self.state.memory[0]
        memory.wander[:] = 0.0
        memory.wander_squared = memory.wander_time = memory.speed_squared = 0.0

    @property
    def down(self) -> FloatArray:
        """The unit down vector (3,) in b."""
        return np.array(self.state.C_nb[2])

    @property
    def sigma(self) -> float:
        """1 sigma [rad] of the down vector's direction."""
        return float(np.sqrt(self.state.P[0, 0] + self.state.P[1, 1]))

    @property
    def gyro_bias(self) -> tuple[FloatArray, FloatArray]:
        """The gyro bias (3,) [rad/s] and its 1 sigma."""
        return np.array(self.state.slow[0].gyro_bias), np.sqrt(np.diag(self.state.P)[6:9])

    @property
    def force_bias_std(self) -> FloatArray:
        """1 sigma (3,) [m/s2] of the accelerometers' biases."""
        std: FloatArray = np.sqrt(np.diag(self.state.P)[12:15])
        return std

    @property
    def at_rest(self) -> bool:
        """Whether the unit was found at rest at the last update."""
        return bool(self.state.memory[0].at_rest)
