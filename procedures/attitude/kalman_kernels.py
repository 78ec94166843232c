"""One sample of the Kalman filter, and a whole log: the same code."""

import math

from procedures.arrays import FloatArray
from procedures.attitude.gnss_velocity_measurement import measure_gnss_velocity, remember_update
from procedures.attitude.kalman_measurements import (
    measure_airspeed,
    measure_heading,
    measure_level_velocity,
    measure_rest,
)
from procedures.attitude.kalman_state import SINCE_UPDATE, KalmanSettings, KalmanState
from procedures.attitude.kalman_update import propagate
from procedures.attitude.kernel_options import inlined, kernel
from procedures.attitude.strapdown_integration import (
    LOST_ANGLE,
    align,
    apply_correction,
    integrate_sample,
    unseen_rate,
)
from procedures.counts.sample_times import GAP_PERIODS

WANDER_S = 5.0  # over which the velocity's wandering is summed: noise is gone by then, a vehicle's speed is not
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
    """Sum up how the velocity spreads about the zero that it is measured as, and how it wanders from it.

    The integral that fades, ``I' = v - I/T``, of white noise of density N has a mean square of N^2 T / 2: two axes
    of it over T are N^2, whatever the filter expects.
    """
    memory = s.memory[0]
    T = memory.time
    left = math.exp(-T / WANDER_S)
    squared = 0.0
    for i in range(2):
        memory.wander[i] = left * memory.wander[i] + T * s.v_n[i]
        squared += memory.wander[i] ** 2 / WANDER_S
    memory.wander_squared += squared * T
    memory.wander_time += T
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
