"""Measurements of the Kalman filter: velocity without aid, by airspeed, by GNSS; a heading; rest.

A GNSS velocity is measured at its own moment, which may be some tenths of a second ago.
"""

import math

from procedures.arrays import FloatArray
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.kalman_state import KalmanState, measure
from procedures.attitude.kernel_options import inlined

REST_MEAN_S = 0.5  # over which rest's means are taken
MEAN_SPEED_S = 1.0
REST_NORM_TOLERANCE = 0.05  # of gravity: accelerometers are no better, and braking at a steady 0.4 g is no rest


@inlined
def measure_level_velocity(s: KalmanState, c: KalmanSettings, i: int, measured: float, variance: float) -> None:
    """Measure component ``i`` of the velocity in north-east-down."""
    s.at[0], s.H[0] = 3 + i, 1.0
    measure(s, 1, s.v_n[i] - measured, variance, c.believed_sigma)


@inlined
def measure_rest_velocity(s: KalmanState, c: KalmanSettings, variance: float) -> None:
    """Measure that the velocity is zero, and learn nothing of accelerometer biases across gravity from it.

    At rest these cannot be distinguished from a tilt: they are held (Schmidt's update), estimate and covariance.
    """
    for i in range(3):
        s.held[3, i] = s.dx[12 + i]
        for j in range(3):
            s.held[i, j] = s.P[12 + i, 12 + j]
    measure_level_velocity(s, c, 0, 0.0, variance)
    measure_level_velocity(s, c, 1, 0.0, variance)
    for i in range(3):
        s.dx[12 + i] = s.held[3, i]
        for j in range(3):
            s.P[12 + i, 12 + j] = s.held[i, j]
    measure_level_velocity(s, c, 2, 0.0, variance)


@inlined
def measure_body_velocity(
    s: KalmanState, c: KalmanSettings, axis: int, along: float, angle: float, noise: float
) -> None:
    """Measure a body component of the velocity: ``along`` [m/s], or it times an ``angle`` [rad] of the airflow."""
    C, v, H, at = s.C_nb, s.v_n, s.H, s.at
    c0, c1, c2 = C[0, axis], C[1, axis], C[2, axis]
    H[0], H[1], H[2] = c1 * v[2] - c2 * v[1], c2 * v[0] - c0 * v[2], c0 * v[1] - c1 * v[0]
    H[3], H[4], H[5] = c0, c1, c2
    for k in range(6):
        at[k] = k
    error = c0 * v[0] + c1 * v[1] + c2 * v[2]
    variance = noise * noise / s.memory[0].time
    if axis == 0:
        measure(s, 6, error - along, variance, c.believed_sigma)
    else:
        H[6], at[6] = -along, 15 if axis == 2 else 16
        measure(s, 7, error - along * angle, variance, c.believed_sigma)


@inlined
def reset_covariance(s: KalmanState, c: KalmanSettings) -> None:
    """Believe vertical and biases no more than at the start: without its aid the filter took motion for none."""
    for i in range(3):
        s.slow[0].gyro_bias[i] = 0.0
    for i in range(9):
        if i != 2:  # the heading is as good as it was
            for j in range(len(s.dx)):
                s.P[i, j] = s.P[j, i] = 0.0
            s.P[i, i] = c.tilt_std**2 if i < 3 else c.velocity_std**2 if i < 6 else c.gyro_bias_std**2


@inlined
def set_velocity(s: KalmanState, north: float, east: float, down: float, std: float) -> None:
    """Reset the velocity [m/s], with the same 1 sigma on each axis: the first value of an aid is no outlier."""
    for i in range(3):
        for j in range(len(s.dx)):
            s.P[3 + i, j] = s.P[j, 3 + i] = 0.0
        s.P[3 + i, 3 + i] = std * std
    s.v_n[0], s.v_n[1], s.v_n[2] = north, east, down
    s.memory[0].velocity_known = 1.0


@inlined
def measure_airspeed(s: KalmanState, c: KalmanSettings) -> None:
    """Take in the airspeed since the last update, angle of attack, sideslip, and a weak word on climbing."""
    V = s.memory[0].airspeed_sum / s.memory[0].airspeed_rows
    if s.memory[0].velocity_known == 0.0:
        C, std = s.C_nb, c.velocity_std + c.velocity_std_per_speed * abs(V)
        if abs(V) > c.rest_speed:
            reset_covariance(s, c)
        set_velocity(s, C[0, 0] * V, C[1, 0] * V, C[2, 0] * V, std)
        return
    measure_body_velocity(s, c, 0, V, 0.0, c.airspeed_noise)
    measure_body_velocity(s, c, 1, V, s.slow[0].slip, c.gust_noise)
    measure_body_velocity(s, c, 2, V, s.slow[0].attack, c.gust_noise)
    climb = c.climb_noise + c.climb_noise_per_speed * abs(V)
    measure_level_velocity(s, c, 2, 0.0, climb * climb / s.memory[0].time)


@inlined
def heading_of(s: KalmanState) -> float:
    """Return the heading [rad] of body x in the filter's level frame."""
    return math.atan2(s.C_nb[1, 0], s.C_nb[0, 0])


@inlined
def turn_level_frame(s: KalmanState, angle: float, std: float) -> None:
    """Turn north by ``angle`` [rad], so that it is true within ``std``: attitude, velocity, covariance."""
    cos, sin = math.cos(angle), math.sin(angle)
    n = len(s.dx)
    for j in range(3):
        a, b = s.C_nb[0, j], s.C_nb[1, j]
        s.C_nb[0, j], s.C_nb[1, j] = cos * a - sin * b, sin * a + cos * b
    a, b = s.v_n[0], s.v_n[1]
    s.v_n[0], s.v_n[1] = cos * a - sin * b, sin * a + cos * b
    for i in (0, 3):
        for j in range(n):
            a, b = s.P[i, j], s.P[i + 1, j]
            s.P[i, j], s.P[i + 1, j] = cos * a - sin * b, sin * a + cos * b
        for j in range(n):
            a, b = s.P[j, i], s.P[j, i + 1]
            s.P[j, i], s.P[j, i + 1] = cos * a - sin * b, sin * a + cos * b
    for j in range(n):
        s.P[2, j] = s.P[j, 2] = 0.0
    for k in range(len(s.past)):
        a, b = s.past[k, 1], s.past[k, 2]
        s.past[k, 1], s.past[k, 2] = cos * a - sin * b, sin * a + cos * b
    s.P[2, 2] = std * std
    s.memory[0].heading_known = 1.0


@inlined
def measure_heading(s: KalmanState, c: KalmanSettings, heading: float) -> None:
    """Take in a true heading [rad]; where body x stands near the vertical it says nothing."""
    if abs(s.C_nb[2, 0]) > 0.98:
        return
    if s.memory[0].heading_known == 0.0:
        turn_level_frame(s, heading - heading_of(s), c.heading_std)
        return
    error = heading_of(s) - heading
    error -= 2 * math.pi * math.floor(error / (2 * math.pi) + 0.5)
    level2 = s.C_nb[0, 0] ** 2 + s.C_nb[1, 0] ** 2
    s.at[0], s.at[1], s.at[2] = 0, 1, 2  # d heading of a small turn of the level frame
    s.H[0] = -s.C_nb[0, 0] * s.C_nb[2, 0] / level2
    s.H[1] = -s.C_nb[1, 0] * s.C_nb[2, 0] / level2
    s.H[2] = 1.0
    measure(s, 3, error, c.heading_std**2, c.believed_sigma)


@inlined
def judge_stillness(s: KalmanState, c: KalmanSettings) -> None:
    """Say whether the unit stood still over a span of at least ``c.update_s``, whatever cut the update.

    A fix or a heading cuts an update short, at worst to one sample. In that a count of a coarse unit is 0.05 g, as
    if it were moved; over the span it is what it always is. Until the span is full the last word stands.
    """
    memory = s.memory[0]
    memory.span_time += memory.time
    for i in range(3):
        memory.span_rate[i] += memory.rate_integral[i]
        memory.span_force[i] += memory.force_integral[i]
    T = memory.span_time
    if T < c.update_s - 1e-9:
        return
    share = min(T / REST_MEAN_S, 1.0)
    off_rate = off_force = norm2 = 0.0
    turns = False  # beyond what the gyros' biases may be
    for i in range(3):
        rate, force = memory.span_rate[i] / T, memory.span_force[i] / T
        norm2 += force * force
        a, b = rate - memory.mean_rate[i], force - memory.mean_force[i]
        off_rate += a * a
        off_force += b * b
        memory.mean_rate[i] += share * a
        memory.mean_force[i] += share * b
        limit = c.rest_rate + 3.0 * math.sqrt(s.P[6 + i, 6 + i])
        turns = turns or abs(memory.mean_rate[i] - s.slow[0].gyro_bias[i]) > limit
    still = off_rate < c.rest_rate**2 and off_force < c.rest_force**2 and not turns
    still = still and abs(math.sqrt(norm2) - c.gravity) < REST_NORM_TOLERANCE * c.gravity
    memory.still_time = memory.still_time + T if still else 0.0
    memory.span_time = 0.0
    memory.span_rate[:] = 0.0
    memory.span_force[:] = 0.0


@inlined
def measure_rest(s: KalmanState, c: KalmanSettings, aided: bool) -> bool:
    """Say whether the unit rests, and if so measure it: no velocity and, where an aid says so too, no rate.

    Rest is rates and specific force that stand still for a while, and no speed by the aid. Without aid a slow
    steady turn looks the same, so that the rate is then left alone; and so does a steady cruise in a vehicle: its
    velocity then restarts at zero (any steady frame will do), and the rate determines the bias loosely.
    """
    memory = s.memory[0]
    T = memory.time
    judge_stillness(s, c)
    if memory.airspeed_rows > 0:
        V, share = memory.airspeed_sum / memory.airspeed_rows, min(T / MEAN_SPEED_S, 1.0)
        memory.speed = V if math.isnan(memory.speed) else memory.speed + share * (V - memory.speed)
    resting = memory.still_time >= c.rest_s and not abs(memory.speed) > c.rest_speed
    may_cruise = c.cruise_std > 0.0
    if resting and memory.at_rest == 0.0 and may_cruise:
        set_velocity(s, 0.0, 0.0, 0.0, c.cruise_std)
    memory.at_rest = 1.0 if resting else 0.0
    if resting:
        measure_rest_velocity(s, c, c.rest_velocity_noise**2 / T)
        if may_cruise or (aided and memory.speed == memory.speed):
            for i in range(3):
                rate = memory.rate_integral[i] / T
                s.at[0], s.at[1] = 6 + i, 9 + i
                s.H[0], s.H[1] = 1.0, rate
                earth = s.C_nb[0, i] * c.earth_north * memory.heading_known + s.C_nb[2, i] * c.earth_down
                expected = s.slow[0].gyro_bias[i] + s.slow[0].gyro_scale[i] * rate + earth
                variance = (c.rest_rate_noise**2 + c.gyro_noise**2) / T
                measure(s, 2, expected - rate, variance, c.believed_sigma)
    return resting


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
    """Take in a GNSS velocity ``vel`` (3,) [m/s]; the first fast enough gives the heading where none was given."""
    sum_since(s, c.fix_latency)
    speed = math.hypot(vel[0], vel[1])
    if math.isnan(s.memory[0].speed) and speed > c.rest_speed:
        reset_covariance(s, c)
    s.memory[0].speed = speed
    knows_heading = s.memory[0].heading_known > 0.0
    is_reset = s.memory[0].velocity_known == 0.0
    if not knows_heading and speed > c.course_speed:
        turn_level_frame(s, math.atan2(vel[1], vel[0]) + s.gained[4] - heading_of(s), c.course_std)
        sum_since(s, c.fix_latency)
        knows_heading = is_reset = True
    if knows_heading and is_reset:
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
