"""The joint filter between updates: start-up alignment, strapdown integration, gaps, saturation."""

import math

from procedures.arrays import FloatArray
from procedures.attitude.joint_state import (
    AIR,
    AIR_ROWS,
    ALPHA,
    BETA,
    BIAS,
    BLOCK,
    DV,
    FORCE,
    FORCE_BIAS,
    HEADING_KNOWN,
    LAST_RATE,
    LOST_ANGLE,
    LOST_SPEED,
    RATE,
    SCALE,
    SPEED,
    STARTED,
    TIME,
    TURNED2,
    VELOCITY_KNOWN,
    Settings,
    State,
)  # fmt: skip
from procedures.attitude.kernel_options import inlined

GAP = 1.5  # nominal intervals: above it a gap, in which motion went on unseen
GAP_RATE, GAP_FORCE = 0.2, 2.0  # rad/s, m/s2: 1 sigma of what it may have been
LONG_GAP_S = 5.0  # after which attitude and velocity begin anew; the biases are kept


@inlined
def start(s: State, c: Settings, x: float, y: float, z: float, air: float) -> None:
    """Align to the first specific force (x, y, z) [m/s2]; the heading is body x's, called north."""
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
    first = s.block[STARTED] == 0.0
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
    for i in range(BLOCK):
        s.block[i] = 0.0
    s.sums[:] = 0.0
    s.past[:] = 0.0
    s.block[STARTED] = 1.0
    s.block[SPEED] = math.nan
    s.block[VELOCITY_KNOWN] = 1.0 if air == air else 0.0


@inlined
def take(
    C: FloatArray, v: FloatArray, slow: FloatArray, sums: FloatArray, block: FloatArray, c: Settings, dt: float,
    p: float, q: float, r: float, x: float, y: float, z: float, air: float,
) -> None:  # fmt: skip
    """Integrate attitude and velocity over one sample and add up what the update needs.

    Rates and specific force are means over ``dt`` [s]; the force acts at half of the turn.
    """
    if dt > GAP * c.nominal_s:
        block[LOST_ANGLE] += (GAP_RATE + 0.5 * math.sqrt(p * p + q * q + r * r)) * (dt - c.nominal_s)
        block[LOST_SPEED] += GAP_FORCE * (dt - c.nominal_s)
        half = 0.5 * (1.0 - c.nominal_s / dt)  # what is known of the gap: the rates on both sides
        p += half * (block[LAST_RATE] - p)
        q += half * (block[LAST_RATE + 1] - q)
        r += half * (block[LAST_RATE + 2] - r)
    block[LAST_RATE], block[LAST_RATE + 1], block[LAST_RATE + 2] = p, q, r
    if abs(p) >= c.rate_limit or abs(q) >= c.rate_limit or abs(r) >= c.rate_limit:
        block[LOST_ANGLE] += 0.5 * c.rate_limit * dt  # the rate may have been half as fast again
    if abs(x) >= c.force_limit or abs(y) >= c.force_limit or abs(z) >= c.force_limit:
        block[LOST_SPEED] += 0.5 * c.force_limit * dt
    north = c.earth_north * block[HEADING_KNOWN]
    t0 = (p - slow[BIAS] - slow[SCALE] * p - C[0, 0] * north - C[2, 0] * c.earth_down) * dt
    t1 = (q - slow[BIAS + 1] - slow[SCALE + 1] * q - C[0, 1] * north - C[2, 1] * c.earth_down) * dt
    t2 = (r - slow[BIAS + 2] - slow[SCALE + 2] * r - C[0, 2] * north - C[2, 2] * c.earth_down) * dt
    f0, f1, f2 = (x - slow[FORCE_BIAS]) * dt, (y - slow[FORCE_BIAS + 1]) * dt, (z - slow[FORCE_BIAS + 2]) * dt
    h0 = f0 + 0.5 * (t1 * f2 - t2 * f1)
    h1 = f1 + 0.5 * (t2 * f0 - t0 * f2)
    h2 = f2 + 0.5 * (t0 * f1 - t1 * f0)
    a2 = t0 * t0 + t1 * t1 + t2 * t2
    if a2 > 0.25:
        a = math.sqrt(a2)
        sine, cosine = math.sin(a) / a, (1.0 - math.cos(a)) / a2
    else:
        sine = 1.0 - a2 / 6.0 * (1.0 - a2 / 20.0 * (1.0 - a2 / 42.0))
        cosine = 0.5 * (1.0 - a2 / 12.0 * (1.0 - a2 / 30.0 * (1.0 - a2 / 56.0)))
    for i in range(3):
        c0, c1, c2 = C[i, 0], C[i, 1], C[i, 2]
        dv = c0 * h0 + c1 * h1 + c2 * h2
        block[DV + i] += dv
        v[i] += dv
        c0, c1, c2 = c0 * dt, c1 * dt, c2 * dt
        sums[i, 0] += c0
        sums[i, 1] += c1
        sums[i, 2] += c2
        sums[i, 3] += c0 * p
        sums[i, 4] += c1 * q
        sums[i, 5] += c2 * r
        c0, c1, c2 = C[i, 0], C[i, 1], C[i, 2]
        u0, u1, u2 = c1 * t2 - c2 * t1, c2 * t0 - c0 * t2, c0 * t1 - c1 * t0
        C[i, 0] = c0 + sine * u0 + cosine * (u1 * t2 - u2 * t1)
        C[i, 1] = c1 + sine * u1 + cosine * (u2 * t0 - u0 * t2)
        C[i, 2] = c2 + sine * u2 + cosine * (u0 * t1 - u1 * t0)
    v[2] += c.gravity * dt
    block[TIME] += dt
    block[TURNED2] += (p * p + q * q + r * r) * dt
    block[RATE] += p * dt
    block[RATE + 1] += q * dt
    block[RATE + 2] += r * dt
    block[FORCE] += x * dt
    block[FORCE + 1] += y * dt
    block[FORCE + 2] += z * dt
    if air == air:
        block[AIR] += air
        block[AIR_ROWS] += 1.0


@inlined
def correct(s: State) -> None:
    """Take the errors ``dx`` (n,) off the state, and square C_nb up."""
    C, dx, slow = s.C_nb, s.dx, s.slow
    a0, a1, a2 = -dx[0], -dx[1], -dx[2]
    a = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2) + 1e-12
    sine, cosine = math.sin(a) / a, (1.0 - math.cos(a)) / (a * a)
    for j in range(3):
        c0, c1, c2 = C[0, j], C[1, j], C[2, j]
        u0, u1, u2 = a1 * c2 - a2 * c1, a2 * c0 - a0 * c2, a0 * c1 - a1 * c0
        C[0, j] = c0 + sine * u0 + cosine * (a1 * u2 - a2 * u1)
        C[1, j] = c1 + sine * u1 + cosine * (a2 * u0 - a0 * u2)
        C[2, j] = c2 + sine * u2 + cosine * (a0 * u1 - a1 * u0)
    for i in range(3):
        s.v_n[i] -= dx[3 + i]
        slow[BIAS + i] -= dx[6 + i]
        slow[SCALE + i] -= dx[9 + i]
        slow[FORCE_BIAS + i] -= dx[12 + i]
    if len(dx) > 15:
        slow[ALPHA] -= dx[15]
        slow[BETA] -= dx[16]
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
