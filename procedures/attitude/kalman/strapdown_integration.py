"""The Kalman filter between updates: start-up alignment, strapdown integration, gaps, saturation."""

import math

from procedures.arrays import FloatArray
from procedures.attitude.complementary_kernels import sine_and_cosine, turn_vector
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.kalman_state import KalmanState
from procedures.attitude.kernel_options import inlined
from procedures.counts.sample_times import GAP_PERIODS

GAP_RATE, GAP_FORCE = 0.2, 2.0  # rad/s, m/s2: 1 sigma of what it may have been
LOST_ANGLE = 1.0  # rad, 1 sigma over a gap: beyond, attitude and velocity restart; the biases are kept


@inlined
def unseen_rate(omega_b: FloatArray) -> float:
    """Return 1 sigma [rad/s] of the rate within a gap that ends at the rates ``omega_b`` (3,)."""
    return GAP_RATE + 0.5 * math.sqrt(omega_b[0] ** 2 + omega_b[1] ** 2 + omega_b[2] ** 2)


@inlined
def align(s: KalmanState, c: KalmanSettings, f_b: FloatArray, air: float) -> None:
    """Align to the first specific force ``f_b`` (3,) [m/s2]; the heading is body x's, called north."""
    x, y, z = f_b[0], f_b[1], f_b[2]
    norm = math.sqrt(x * x + y * y + z * z)
    d0, d1, d2 = (-x / norm, -y / norm, -z / norm) if norm > 1e-6 else (0.0, 0.0, 1.0)
    i = 0 if abs(d0) < 0.9 else 1  # the body axis that is called north: one that is not vertical
    C = s.C_nb
    C[2, 0], C[2, 1], C[2, 2] = d0, d1, d2
    across = math.sqrt(1.0 - C[2, i] * C[2, i])
    for j in range(3):
        C[0, j] = ((1.0 if j == i else 0.0) - C[2, i] * C[2, j]) / across
    for j in range(3):  # east = down x north
        k, m = (j + 1) % 3, (j + 2) % 3
        C[1, j] = C[2, k] * C[0, m] - C[2, m] * C[0, k]
    n = len(s.dx)
    first = s.memory[0].started == 0.0
    for i in range(6):
        for j in range(n):
            s.P[i, j] = s.P[j, i] = 0.0
    v_std = c.velocity_std
    for i in range(3):
        s.v_n[i] = C[i, 0] * air if air == air else 0.0
    if air == air:
        v_std += c.velocity_std_per_speed * abs(air)
    for i in range(3):
        s.P[i, i] = c.tilt_std**2 if i < 2 else 0.0  # north is where the filter says it is
        s.P[3 + i, 3 + i] = v_std**2
        if first:
            s.P[6 + i, 6 + i] = c.gyro_bias_std**2
            s.P[9 + i, 9 + i] = c.gyro_scale_std**2
            s.P[12 + i, 12 + i] = c.force_bias_std**2
    if first and n > 15:
        s.P[15, 15], s.P[16, 16] = c.attack_std**2, c.slip_std**2
    s.flat[:] = 0.0
    s.sums[:] = 0.0
    s.past[:] = 0.0
    s.memory[0].started = 1.0
    s.memory[0].speed = math.nan
    s.memory[0].velocity_known = 1.0 if air == air else 0.0


@inlined
def integrate_sample(
    s: KalmanState, c: KalmanSettings, dt: float, omega_b: FloatArray, f_b: FloatArray, air: float
) -> None:
    """Integrate attitude and velocity over one sample and add up what the update needs.

    ``omega_b`` (3,) [rad/s] and ``f_b`` (3,) [m/s2] are means over ``dt`` [s]; the force acts at half of the turn.
    """
    C, v, slow, sums, memory, rate = s.C_nb, s.v_n, s.slow[0], s.sums, s.memory[0], s.memory[0].last_rate
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    x, y, z = f_b[0], f_b[1], f_b[2]
    if dt > GAP_PERIODS * c.nominal_s:
        memory.unseen_angle += unseen_rate(omega_b) * (dt - c.nominal_s)
        memory.unseen_velocity += GAP_FORCE * (dt - c.nominal_s)
        half = 0.5 * (1.0 - c.nominal_s / dt)  # what is known of the gap: the rates on both sides
        p += half * (rate[0] - p)
        q += half * (rate[1] - q)
        r += half * (rate[2] - r)
    rate[0], rate[1], rate[2] = p, q, r
    if abs(p) >= c.rate_limit or abs(q) >= c.rate_limit or abs(r) >= c.rate_limit:
        memory.unseen_angle += 0.5 * c.rate_limit * dt  # the rate may have been half as fast again
    if abs(x) >= c.force_limit or abs(y) >= c.force_limit or abs(z) >= c.force_limit:
        memory.unseen_velocity += 0.5 * c.force_limit * dt
    north = c.earth_north * memory.heading_known
    t0 = (p - slow.gyro_bias[0] - slow.gyro_scale[0] * p - C[0, 0] * north - C[2, 0] * c.earth_down) * dt
    t1 = (q - slow.gyro_bias[1] - slow.gyro_scale[1] * q - C[0, 1] * north - C[2, 1] * c.earth_down) * dt
    t2 = (r - slow.gyro_bias[2] - slow.gyro_scale[2] * r - C[0, 2] * north - C[2, 2] * c.earth_down) * dt
    f0, f1, f2 = (x - slow.force_bias[0]) * dt, (y - slow.force_bias[1]) * dt, (z - slow.force_bias[2]) * dt
    h0 = f0 + 0.5 * (t1 * f2 - t2 * f1)
    h1 = f1 + 0.5 * (t2 * f0 - t0 * f2)
    h2 = f2 + 0.5 * (t0 * f1 - t1 * f0)
    sine, cosine = sine_and_cosine(t0 * t0 + t1 * t1 + t2 * t2)
    for i in range(3):
        dv = C[i, 0] * h0 + C[i, 1] * h1 + C[i, 2] * h2
        memory.velocity_gain[i] += dv
        v[i] += dv
        for j in range(3):
            sums[i, j] += C[i, j] * dt
            sums[i, 3 + j] += C[i, j] * dt * rate[j]
        turn_vector(C[i], t0, t1, t2, sine, cosine)
    v[2] += c.gravity * dt
    memory.time += dt
    memory.rate_squared += (p * p + q * q + r * r) * dt
    for i in range(3):
        memory.rate_integral[i] += rate[i] * dt
        memory.force_integral[i] += f_b[i] * dt
    if air == air:
        memory.airspeed_sum += air
        memory.airspeed_rows += 1.0


@inlined
def apply_correction(s: KalmanState) -> None:
    """Take the errors ``dx`` (n,) off the state, and square C_nb up."""
    C, dx, slow = s.C_nb, s.dx, s.slow[0]
    a = math.sqrt(dx[0] * dx[0] + dx[1] * dx[1] + dx[2] * dx[2]) + 1e-12
    sine, cosine = math.sin(a) / a, (1.0 - math.cos(a)) / (a * a)
    for j in range(3):
        turn_vector(C[:, j], dx[0], dx[1], dx[2], sine, cosine)
    for i in range(3):
        s.v_n[i] -= dx[3 + i]
        slow.gyro_bias[i] -= dx[6 + i]
        slow.gyro_scale[i] -= dx[9 + i]
        slow.force_bias[i] -= dx[12 + i]
    if len(dx) > 15:
        slow.attack -= dx[15]
        slow.slip -= dx[16]
    # C (3 I - C'C) / 2: one step of Newton towards the nearest rotation
    g00 = 1.5 - 0.5 * (C[0, 0] ** 2 + C[1, 0] ** 2 + C[2, 0] ** 2)
    g11 = 1.5 - 0.5 * (C[0, 1] ** 2 + C[1, 1] ** 2 + C[2, 1] ** 2)
    g22 = 1.5 - 0.5 * (C[0, 2] ** 2 + C[1, 2] ** 2 + C[2, 2] ** 2)
    g01 = -0.5 * (C[0, 0] * C[0, 1] + C[1, 0] * C[1, 1] + C[2, 0] * C[2, 1])
    g02 = -0.5 * (C[0, 0] * C[0, 2] + C[1, 0] * C[1, 2] + C[2, 0] * C[2, 2])
    g12 = -0.5 * (C[0, 1] * C[0, 2] + C[1, 1] * C[1, 2] + C[2, 1] * C[2, 2])
    for i in range(3):
        c0, c1, c2 = C[i, 0], C[i, 1], C[i, 2]
        C[i, 0] = c0 * g00 + c1 * g01 + c2 * g02
        C[i, 1] = c0 * g01 + c1 * g11 + c2 * g12
        C[i, 2] = c0 * g02 + c1 * g12 + c2 * g22
