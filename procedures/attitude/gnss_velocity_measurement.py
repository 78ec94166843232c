"""A GNSS velocity in the Kalman filter: at its own moment, which may be some tenths of a second ago."""

import math

from procedures.arrays import FloatArray
from procedures.attitude.kalman_measurements import (
    heading_of,
    measure_level_velocity,
    reset_covariance,
    set_velocity,
    turn_level_frame,
)
from procedures.attitude.kalman_state import KalmanSettings, KalmanState
from procedures.attitude.kalman_update import measure
from procedures.attitude.kernel_options import inlined


@inlined
def remember_update(s: KalmanState, c: KalmanSettings) -> None:
    """Keep what velocity and heading gained since the last update, without its corrections."""
    memory, n = s.memory[0], len(s.past)
    at = (int(memory.newest) + 1) % n
    memory.newest = at
    s.past[at, 0] = memory.time
    for i in range(3):
        s.past[at, 1 + i] = memory.velocity_gain[i]
    s.past[at, 3] += c.gravity * memory.time
    C, turn = s.C_nb, memory.rate_integral
    s.past[at, 4] = C[2, 0] * turn[0] + C[2, 1] * turn[1] + C[2, 2] * turn[2]


@inlined
def sum_since(s: KalmanState, seconds: float) -> None:
    """Sum the ring over the last ``seconds`` [s], as far as it reaches, into ``s.gained`` (5,)."""
    n, at, gained = len(s.past), int(s.memory[0].newest), s.gained
    gained[:] = 0.0
    for _ in range(n):
        T = s.past[at, 0]
        if seconds <= 0.0 or T <= 0.0:
            break
        share = min(seconds / T, 1.0)
        for i in range(5):
            gained[i] += s.past[at, i] * share
        seconds -= T
        at = (at + n - 1) % n


@inlined
def measure_gnss_velocity(s: KalmanState, c: KalmanSettings, vel: FloatArray) -> None:
    """Take in a GNSS velocity ``vel`` (3,) [m/s]; the first fast enough gives the heading where none was given.

    The filter's own velocity carries the motion over the fix interval, so that what is compared are velocity
    increments, not accelerations at a point; and likewise from the moment of the fix to now.
    """
    sum_since(s, c.fix_latency)
    speed = math.hypot(vel[0], vel[1])
    if math.isnan(s.memory[0].speed) and speed > c.rest_speed:
        reset_covariance(s, c)
    s.memory[0].speed = speed
    knows_heading = s.memory[0].heading_known > 0.0
    anew = s.memory[0].velocity_known == 0.0
    if not knows_heading and speed > c.course_speed:
        turn_level_frame(s, math.atan2(vel[1], vel[0]) + s.gained[4] - heading_of(s), c.course_std)
        sum_since(s, c.fix_latency)
        knows_heading = anew = True
    if knows_heading and anew:
        north, east, down = vel[0] + s.gained[1], vel[1] + s.gained[2], vel[2] + s.gained[3]
        set_velocity(s, north, east, down, 2 * c.velocity_fix_std)
        return
    for i in range(3):
        if knows_heading or i == 2:
            measure_delayed_velocity(s, c, i, vel[i])
        else:  # as far as the speed goes in some direction
            measure_level_velocity(s, c, i, 0.0, c.velocity_fix_std**2 + speed * speed)


@inlined
def measure_delayed_velocity(s: KalmanState, c: KalmanSettings, i: int, measured: float) -> None:
    """Measure component ``i`` [m/s] of the velocity as it was at the fix.

    It is v less what was gained since, and that is wrong by psi x (what specific force gained).
    """
    gained = s.gained
    j, k = (i + 1) % 3, (i + 2) % 3
    by_weight = c.gravity * gained[0]
    s.at[0], s.H[0] = 3 + i, 1.0
    s.at[1], s.H[1] = j, -(gained[1 + k] - (by_weight if k == 2 else 0.0))
    s.at[2], s.H[2] = k, gained[1 + j] - (by_weight if j == 2 else 0.0)
    measure(s, 3, s.v_n[i] - gained[1 + i] - measured, c.velocity_fix_std**2, c.believed_sigma)
