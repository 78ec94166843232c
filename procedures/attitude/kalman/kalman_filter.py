"""The Kalman filter of attitude, velocity and biases: the default of every aid.

One error-state filter; only the velocity measurement changes with the aid. Attitude error and velocity share one
covariance, which is what You and Lee's velocity filter lacks: there the error of attitude is taken for velocity,
and in a turn beyond a minute the two feed each other.
"""

import math
from copy import copy

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman.kalman_measurements import (
    measure_airspeed,
    measure_gnss_velocity,
    measure_heading,
    measure_level_velocity,
    measure_rest,
    remember_update,
)
from procedures.attitude.kalman.kalman_settings import AIDED_SETTINGS, KalmanSettings
from procedures.attitude.kalman.kalman_state import SINCE_UPDATE, KalmanState, new_state, propagate
from procedures.attitude.kalman.strapdown_integration import (
    LOST_ANGLE,
    align,
    apply_correction,
    integrate_sample,
    unseen_rate,
)
from procedures.attitude.kernel_options import inlined, kernel
from procedures.counts.sample_times import GAP_PERIODS

DRIFT_S = 5.0  # over which the velocity's drift is summed: noise is gone by then, a vehicle's speed is not
NO_AID, AIRSPEED, GNSS = 0, 1, 2


@inlined
def advance(
    s: KalmanState, c: KalmanSettings, aid: int, dt: float, omega_b: FloatArray, f_b: FloatArray, air: float,
    vel: FloatArray, heading: float,
) -> None:  # fmt: skip
    """Advance by one sample.

    Parameters
    ----------
    omega_b, f_b : (3,), rad/s, m/s2
    vel : (3,), m/s, north-east-down
        Nan where there is none, as are ``air`` [m/s] and ``heading`` [rad].
    """
    if aid != AIRSPEED:
        air = math.nan  # an aid that was not asked for is not used at all
    is_gap = dt > GAP_PERIODS * c.nominal_s
    if s.memory[0].started == 0.0 or (is_gap and unseen_rate(omega_b) * (dt - c.nominal_s) > LOST_ANGLE):
        align(s, c, f_b, air)
        if heading == heading:
            measure_heading(s, c, heading)
        return
    integrate_sample(s, c, dt, omega_b, f_b, air)
    fixed = aid == GNSS and vel[0] == vel[0] and vel[1] == vel[1] and vel[2] == vel[2]
    if s.memory[0].time >= c.update_s - 1e-9 or fixed or heading == heading:
        update(s, c, aid, fixed, vel, heading)


@inlined
def update(s: KalmanState, c: KalmanSettings, aid: int, fixed: bool, vel: FloatArray, heading: float) -> None:
    """Carry the covariance to now, take in what is measured, ``vel`` (3,) [m/s] too, and correct the state."""
    propagate(s, c)
    s.dx[:] = 0.0
    if aid == GNSS:
        remember_update(s, c)
    if heading == heading:
        measure_heading(s, c, heading)
    resting = measure_rest(s, c, aid != NO_AID)
    if aid == AIRSPEED and s.memory[0].airspeed_rows > 0:
        measure_airspeed(s, c)
    elif fixed:
        measure_gnss_velocity(s, c, vel)
    elif (aid == NO_AID or (s.memory[0].velocity_known == 0.0 and math.isnan(s.memory[0].speed))) and not resting:
        watch_motion(s)
        for i in range(3):
            measure_level_velocity(s, c, i, 0.0, c.speed_noise**2 / s.memory[0].time)
    apply_correction(s)
    s.sums[:] = 0.0
    s.flat[:SINCE_UPDATE] = 0.0


@inlined
def watch_motion(s: KalmanState) -> None:
    """Sum up how the velocity spreads about the zero that it is measured as, and how it drifts from it.

    The integral that fades, ``I' = v - I/T``, of white noise of density N has a mean square of N^2 T / 2: two axes
    of it over T are N^2, whatever the filter expects.
    """
    memory = s.memory[0]
    T = memory.time
    left = math.exp(-T / DRIFT_S)
    squared = 0.0
    for i in range(2):
        memory.drift[i] = left * memory.drift[i] + T * s.v_n[i]
        squared += memory.drift[i] ** 2 / DRIFT_S
    memory.drift_squared += squared * T
    memory.drift_time += T
    for i in range(3):
        memory.speed_squared += s.v_n[i] ** 2 * T


@kernel
def filter_log(
    s: KalmanState, c: KalmanSettings, aid: int, dt: FloatArray, omega_b: FloatArray, f_b: FloatArray,
    air: FloatArray, vel: FloatArray, heading: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Run `advance` over a log.

    Parameters
    ----------
    dt, omega_b, f_b : (n,), s; (n, 3), rad/s; (n, 3), m/s2
    air, vel, heading : (n,), m/s; (n, 3), m/s, north-east-down; (n,), rad
        Aids, nan where there is none.
    out : (n, 4)
        The unit down vector in b of every row, and its sigma [rad].
    """
    for i in range(len(dt)):
        advance(s, c, aid, dt[i], omega_b[i], f_b[i], air[i], vel[i], heading[i])
        out[i, 0], out[i, 1], out[i, 2] = s.C_nb[2, 0], s.C_nb[2, 1], s.C_nb[2, 2]
        out[i, 3] = math.sqrt(s.P[0, 0] + s.P[1, 1])


AID_CODE = {"none": NO_AID, "airspeed-filter": AIRSPEED, "gnss": GNSS}
NO_VELOCITY = np.full(3, np.nan)


class AttitudeKalmanFilter:
    """Attitude of one sample after another; nothing is kept but the state.

    ``aid`` is one of `AID_CODE`. The first sample's specific force is taken for the vertical, within
    ``settings.tilt_std``; a gap of 5 s, of less while it turns fast, restarts with the
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
        """Reset the sums of how the velocity moves about zero."""
        memory = self.state.memory[0]
        memory.drift[:] = 0.0
        memory.drift_squared = memory.drift_time = memory.speed_squared = 0.0

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
        return np.sqrt(np.diag(self.state.P)[12:15])

    @property
    def at_rest(self) -> bool:
        """Whether the unit was found at rest at the last update."""
        return bool(self.state.memory[0].at_rest)
