"""Velocity aids of the mixing law, one sample at a time: forward speed, and the velocity filter of P2 (11)-(14).

``aid`` (24,) holds, by index: 0-2 body velocity u, v, w [m/s]; 3-5 the rate smoothed over `SMOOTH_S` [rad/s]; 6
the remembered angle of attack [rad]; 7 for how long it was learned [s]; 8 time since the start [s]; 9 time with
the gate open [s]; 10 whether the gate is open; 11 the last airspeed [m/s]; 12-20 the velocity covariance, row by
row [m2/s2].
"""

import math

from numba import njit

from procedures.arrays import FloatArray
from procedures.attitude.mixer_kernels import mix_euler, mix_vector

COMPILED_IN = "8463a664ea57"  # of `mixing_kernels`; see `joint_kernels`
SMOOTH_S = 0.5  # of the rates that open the gate
LEARN_S = 20.0  # over which the angle of attack is remembered
Q, R, P0 = 2.0e-9, 100.0, 100.0  # P2, section 4: variances per sample; P0 is not printed, 100 does best


@njit(cache=True)
def open_gate(aid: FloatArray, dt: float, p: float, q: float, r: float, speed: float, gate: float) -> bool:
    """Take in a sample's rates and speed; return whether the unit turns faster than the gate [rad/s]."""
    share = min(dt / SMOOTH_S, 1.0)
    aid[3] += share * (p - aid[3])
    aid[4] += share * (q - aid[4])
    aid[5] += share * (r - aid[5])
    if speed == speed:
        aid[11] = speed
    is_open = bool(aid[3] * aid[3] + aid[4] * aid[4] + aid[5] * aid[5] > gate * gate)
    aid[8] += dt
    aid[9] += dt if is_open else 0.0
    aid[10] = 1.0 if is_open else 0.0
    return is_open


@njit(cache=True)
def mix_speed(
    state: FloatArray, aid: FloatArray, dt: float, p: float, q: float, r: float, x: float, y: float, z: float,
    speed: float, gate: float, k1: float, k2: float,
) -> None:  # fmt: skip
    """Advance the law on the gravity vector, aided by forward speed and the remembered angle of attack.

    Taken off while the gate is open: omega x (u, 0, w), u = V cos a, w = V sin a. While it is closed nothing is,
    since V times a yaw rate's bias would tilt a level flight; there the pitch is the angle of attack.
    """
    if open_gate(aid, dt, p, q, r, speed, gate):
        u, w = aid[11] * math.cos(aid[6]), aid[11] * math.sin(aid[6])
        aid[0], aid[2] = u, w
        x, y, z = x - q * w, y - r * u + p * w, z + q * u
    elif aid[11] > 1.0:
        aid[7] = min(aid[7] + dt, LEARN_S)
        pitch = math.asin(max(-1.0, min(1.0, -state[0])))
        aid[6] += min(dt / aid[7], 1.0) * (pitch - aid[6])
    start = 1.0 / (aid[8] + 0.1)  # a running mean first, the gain once that is the faster
    mix_vector(state, dt, p, q, r, x, y, z, max(k1, start), k2)


@njit(cache=True)
def paper_angles(
    x: float, y: float, u: float, v: float, w: float, p: float, q: float, r: float, g: float
) -> tuple[float, float]:
    """Return phi_a and theta_a [rad] of the specific force and body velocity: P2 (14), and (10) with v = w = 0."""
    theta = math.asin(max(-1.0, min(1.0, (x + r * v - q * w) / g)))
    phi = math.asin(max(-1.0, min(1.0, (-y + r * u - p * w) / (g * max(math.cos(theta), 1e-3)))))
    return phi, theta


@njit(cache=True)
def filter_velocity(
    aid: FloatArray, dt: float, p: float, q: float, r: float, x: float, y: float, z: float, speed: float,
    phi: float, theta: float, g: float,
) -> None:  # fmt: skip
    """Advance the velocity filter by one sample: P2 (11), (12), with the attitude of the sample before."""
    u, v, w = aid[0], aid[1], aid[2]
    aid[0] = u + (r * v - q * w + x - g * math.sin(theta)) * dt
    aid[1] = v + (-r * u + p * w + y + g * math.sin(phi) * math.cos(theta)) * dt
    aid[2] = w + (q * u - p * v + z + g * math.cos(phi) * math.cos(theta)) * dt
    P = aid[12:21].reshape((3, 3))
    for _ in range(2):  # P <- F (F P)': twice the same product of rows
        for j in range(3):
            a, b, c = P[0, j], P[1, j], P[2, j]
            P[0, j], P[1, j], P[2, j] = (
                a + (r * b - q * c) * dt, b + (p * c - r * a) * dt, c + (q * a - p * b) * dt,
            )  # fmt: skip
        for i in range(3):
            for j in range(i):
                P[i, j], P[j, i] = P[j, i], P[i, j]
    for i in range(3):
        P[i, i] += Q
    if speed == speed:
        k0, k1, k2 = P[0, 0] / (P[0, 0] + R), P[1, 0] / (P[0, 0] + R), P[2, 0] / (P[0, 0] + R)
        error = speed - aid[0]
        aid[0] += k0 * error
        aid[1] += k1 * error
        aid[2] += k2 * error
        for j in range(3):
            top = P[0, j]
            P[0, j] -= k0 * top
            P[1, j] -= k1 * top
            P[2, j] -= k2 * top


@njit(cache=True)
def mix_paper(
    state: FloatArray, aid: FloatArray, dt: float, p: float, q: float, r: float, x: float, y: float, z: float,
    speed: float, gate: float, k1: float, k2: float, g: float, filtered: bool,
) -> None:  # fmt: skip
    """Advance the Euler form as printed, aided by forward speed alone (10) or by the velocity filter (11)-(14).

    While the gate is closed the filter's v and w are held and u follows the airspeed.
    """
    is_open = open_gate(aid, dt, p, q, r, speed, gate)
    if filtered and is_open:
        filter_velocity(aid, dt, p, q, r, x, y, z, speed, state[0], state[1], g)
    else:
        aid[0] = aid[11]
    v, w = (aid[1], aid[2]) if filtered else (0.0, 0.0)
    phi_a, theta_a = paper_angles(x, y, aid[0], v, w, p, q, r, g)
    mix_euler(state, dt, p, q, r, phi_a, theta_a, k1, k2)


@njit(cache=True)
def mix_speed_log(
    state: FloatArray, aid: FloatArray, dt: FloatArray, rate: FloatArray, force: FloatArray, speed: FloatArray,
    gate: float, k1: float, k2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Run `mix_speed` over a log: the down vector of every row into ``out`` (n, 3)."""
    for i in range(len(dt)):
        mix_speed(
            state, aid, dt[i], rate[i, 0], rate[i, 1], rate[i, 2], force[i, 0], force[i, 1], force[i, 2],
            speed[i], gate, k1, k2,
        )  # fmt: skip
        out[i, 0], out[i, 1], out[i, 2] = state[0], state[1], state[2]


@njit(cache=True)
def mix_paper_log(
    state: FloatArray, aid: FloatArray, dt: FloatArray, rate: FloatArray, force: FloatArray, speed: FloatArray,
    gate: float, k1: float, k2: float, g: float, filtered: bool, out: FloatArray,
) -> None:  # fmt: skip
    """Run `mix_paper` over a log: roll and pitch [rad] of every row into ``out`` (n, 2)."""
    for i in range(len(dt)):
        mix_paper(
            state, aid, dt[i], rate[i, 0], rate[i, 1], rate[i, 2], force[i, 0], force[i, 1], force[i, 2],
            speed[i], gate, k1, k2, g, filtered,
        )  # fmt: skip
        out[i, 0], out[i, 1] = state[0], state[1]
