"""The mixing law of P2 (eq. 1), one sample at a time: on the gravity vector, and in Euler angles as printed.

On the gravity vector the law reads, with d the down vector and d_a the accelerometer's,

    e = d_a x d    (its length is the sine of the angle between them)
    b' = K1 K2 e,    d' = -(omega + b + K1 e) x d

For small errors each component is (1): phi_m' = phi_g' + K1 e + integral of K1 K2 e. ``state`` (6,) holds d and b,
or phi, theta, their two integrals and two spare. Every kernel has its plain form as ``kernel.py_func``.
"""

import math

from numba import njit

from procedures.arrays import FloatArray

SMALL = 1e-9  # of |f| over g: nothing to see


@njit(cache=True)
def turn(d: FloatArray, x: float, y: float, z: float) -> None:
    """Turn a body-frame image ``d`` (3,) of a fixed vector in place, the body turning by (x, y, z) [rad]."""
    a2 = x * x + y * y + z * z
    if a2 > 0.25:
        a = math.sqrt(a2)
        s, c = math.sin(a) / a, (1 - math.cos(a)) / a2
    else:  # below 0.5 rad the series is exact to 2e-9
        s = 1 - a2 / 6 * (1 - a2 / 20 * (1 - a2 / 42))
        c = 0.5 * (1 - a2 / 12 * (1 - a2 / 30 * (1 - a2 / 56)))
    d0, d1, d2 = d[0], d[1], d[2]
    u0, u1, u2 = d1 * z - d2 * y, d2 * x - d0 * z, d0 * y - d1 * x  # d x theta
    d[0] = d0 + s * u0 + c * (u1 * z - u2 * y)
    d[1] = d1 + s * u1 + c * (u2 * x - u0 * z)
    d[2] = d2 + s * u2 + c * (u0 * y - u1 * x)
    scale = 1.5 - 0.5 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    d[0] *= scale
    d[1] *= scale
    d[2] *= scale


@njit(cache=True)
def mix_vector(
    state: FloatArray, dt: float, p: float, q: float, r: float, x: float, y: float, z: float, k1: float, k2: float
) -> None:
    """Advance the law on the gravity vector by one sample.

    ``x``, ``y``, ``z`` [m/s2] are the specific force with motion acceleration taken off; a force of nought
    leaves the gyro alone.
    """
    norm = math.sqrt(x * x + y * y + z * z)
    e0 = e1 = e2 = 0.0
    if norm > SMALL:
        a0, a1, a2 = -x / norm, -y / norm, -z / norm
        e0, e1, e2 = a1 * state[2] - a2 * state[1], a2 * state[0] - a0 * state[2], a0 * state[1] - a1 * state[0]
        if a0 * state[0] + a1 * state[1] + a2 * state[2] < 0:  # beyond 90 deg the pull stays full
            s = math.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
            if s > 1e-6:
                e0, e1, e2 = e0 / s, e1 / s, e2 / s
            else:  # upside down exactly: any axis across will do, here that to (1, 1, 1)
                e0, e1, e2 = state[1] - state[2], state[2] - state[0], state[0] - state[1]
    state[3] += k1 * k2 * e0 * dt
    state[4] += k1 * k2 * e1 * dt
    state[5] += k1 * k2 * e2 * dt
    turn(
        state, (p + state[3] + k1 * e0) * dt, (q + state[4] + k1 * e1) * dt, (r + state[5] + k1 * e2) * dt
    )  # fmt: skip


@njit(cache=True)
def mix_euler(
    state: FloatArray, dt: float, p: float, q: float, r: float, phi_a: float, theta_a: float, k1: float, k2: float
) -> None:
    """Advance roll and pitch by one sample as printed: eq. 1 per angle, rates by eq. 2.

    The rates are singular at pitch 90 deg; there tan and 1/cos are held at those of 89.9 deg.
    """
    phi, theta = state[0], state[1]
    tangent = max(min(math.tan(theta), 573.0), -573.0)
    rate = q * math.sin(phi) + r * math.cos(phi)
    e_phi, e_theta = phi_a - phi, theta_a - theta
    e_phi -= 2 * math.pi * math.floor(e_phi / (2 * math.pi) + 0.5)
    state[2] += k1 * k2 * e_phi * dt
    state[3] += k1 * k2 * e_theta * dt
    state[0] += (p + tangent * rate + k1 * e_phi + state[2]) * dt
    state[1] += (q * math.cos(phi) - r * math.sin(phi) + k1 * e_theta + state[3]) * dt


@njit(cache=True)
def mix_log(
    state: FloatArray, dt: FloatArray, rate: FloatArray, force: FloatArray, k1: float, k2: float, out: FloatArray
) -> None:
    """Mix a whole log without aid: the down vector of every row into ``out`` (n, 3)."""
    for i in range(len(dt)):
        mix_vector(
            state, dt[i], rate[i, 0], rate[i, 1], rate[i, 2], force[i, 0], force[i, 1], force[i, 2], k1, k2
        )  # fmt: skip
        out[i, 0], out[i, 1], out[i, 2] = state[0], state[1], state[2]
