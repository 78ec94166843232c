"""The complementary filter of You and Lee (eq. 1), a sample at a time: on the gravity vector, and in Euler angles.

On the gravity vector the filter reads, with d the down vector and d_a the accelerometer's,

    e = d_a x d    (its length is the sine of the angle between them)
    b' = K1 K2 e,    d' = -(omega + b + K1 e) x d

For small errors each component is (1): phi_m' = phi_g' + K1 e + integral of K1 K2 e. Every kernel has its plain
form as ``kernel.py_func``. Where a kernel takes records, it takes an array of one: numba unpacks that faster.
"""

import math
from typing import NamedTuple

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.kernel_options import Record, inlined, kernel

MIN_FORCE_NORM = 1e-9  # of |f| over g: nothing to see
# forms of the filter; the printed ones are in Euler angles
VECTOR, VECTOR_SPEED, PRINTED, PRINTED_FILTER, PRINTED_RATE, PRINTED_GNSS = range(6)
FORMS = {
    "none": VECTOR, "airspeed": VECTOR_SPEED, "paper-airspeed": PRINTED, "paper-filter": PRINTED_FILTER,
    "paper-airspeed-rate": PRINTED_RATE, "paper-gnss": PRINTED_GNSS,
}  # fmt: skip
MIXER = np.dtype((np.record, [
    ("down", "f8", 3), ("roll", "f8"), ("pitch", "f8"),  # the one or the others [rad]
    ("correction", "f8", 3),  # added to the rates; to the derivatives of roll and pitch [rad/s]
    ("velocity", "f8", 3),  # u, v, w [m/s], body axes
    ("covariance", "f8", (3, 3)),  # of it [m2/s2]
    ("airspeed", "f8"),  # the last one [m/s]
    ("known", "f8"),  # whether a velocity came yet: 0 or 1
    ("since_s", "f8"),  # since the last one
    ("level", "f8", 3),  # the last one, forward, right, down of the heading; a speed along body x first [m/s]
    ("smooth_level", "f8", 3), ("level_rate", "f8", 3),  # smoothed, and its derivative [m/s2]
    ("steady_rate", "f8"),  # of the speed alone, smoothed over `STEADY_S` [m/s2]
    ("load", "f8"),  # size of the specific force over g, smoothed as the rates are
    ("smooth_rate", "f8", 3),  # smoothed over `SMOOTH_S` [rad/s]
    ("attack", "f8"),  # the remembered angle of attack [rad]
    ("learned_s", "f8"),  # for how long
    ("has_turned", "f8"),  # whether the gate was open yet: 0 or 1
    ("elapsed_s", "f8"),  # since the start
    ("gravity", "f8", 3),  # scratch: specific force with the motion corrected [m/s2]
]))  # fmt: skip


class MixerSettings(NamedTuple):
    """What stays the same: gains [1/s], the gate [rad/s], gravity [m/s2], and the form of the filter."""

    k1: float
    k2: float
    gate: float
    g: float
    form: int = VECTOR


@inlined
def sine_and_cosine(a2: float) -> tuple[float, float]:
    """Return sin(a) / a and (1 - cos(a)) / a2 of the square ``a2`` of an angle a [rad]."""
    if a2 > 0.25:
        a = math.sqrt(a2)
        return math.sin(a) / a, (1.0 - math.cos(a)) / a2
    sine = 1.0 - a2 / 6.0 * (1.0 - a2 / 20.0 * (1.0 - a2 / 42.0))  # below 0.5 rad the series is exact to 2e-9
    return sine, 0.5 * (1.0 - a2 / 12.0 * (1.0 - a2 / 30.0 * (1.0 - a2 / 56.0)))


@inlined
def turn_vector(d: FloatArray, x: float, y: float, z: float, s: float, c: float) -> None:
    """Turn a body-frame image ``d`` (3,) of a fixed vector in place, the body turning by (x, y, z) [rad].

    ``s`` and ``c`` are `sine_and_cosine` of that angle.
    """
    d0, d1, d2 = d[0], d[1], d[2]
    u0, u1, u2 = d1 * z - d2 * y, d2 * x - d0 * z, d0 * y - d1 * x  # d x theta
    d[0] = d0 + s * u0 + c * (u1 * z - u2 * y)
    d[1] = d1 + s * u1 + c * (u2 * x - u0 * z)
    d[2] = d2 + s * u2 + c * (u0 * y - u1 * x)


@kernel
def mix_vector(mixers: Record, dt: float, omega_b: FloatArray, f_b: FloatArray, k1: float, k2: float) -> None:
    """Advance the filter on the gravity vector by one sample.

    ``mixers`` (1,) of `MIXER`, ``omega_b`` (3,) [rad/s]; ``f_b`` (3,) [m/s2] is the specific force with motion
    acceleration corrected; a force of zero leaves the gyro alone.
    """
    d, b = mixers[0].down, mixers[0].correction
    x, y, z = f_b[0], f_b[1], f_b[2]
    norm = math.sqrt(x * x + y * y + z * z)
    e0 = e1 = e2 = 0.0
    if norm > MIN_FORCE_NORM:
        a0, a1, a2 = -x / norm, -y / norm, -z / norm
        e0, e1, e2 = a1 * d[2] - a2 * d[1], a2 * d[0] - a0 * d[2], a0 * d[1] - a1 * d[0]
        if a0 * d[0] + a1 * d[1] + a2 * d[2] < 0:  # beyond 90 deg the pull stays full
            s = math.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
            if s > 1e-6:
                e0, e1, e2 = e0 / s, e1 / s, e2 / s
            else:  # upside down exactly: any axis across will do, here that to (1, 1, 1)
                e0, e1, e2 = d[1] - d[2], d[2] - d[0], d[0] - d[1]
    b[0] += k1 * k2 * e0 * dt
    b[1] += k1 * k2 * e1 * dt
    b[2] += k1 * k2 * e2 * dt
    x, y, z = omega_b[0] + b[0] + k1 * e0, omega_b[1] + b[1] + k1 * e1, omega_b[2] + b[2] + k1 * e2
    x, y, z = x * dt, y * dt, z * dt
    sine, cosine = sine_and_cosine(x * x + y * y + z * z)
    turn_vector(d, x, y, z, sine, cosine)
    scale = 1.5 - 0.5 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    d[0] *= scale
    d[1] *= scale
    d[2] *= scale


@kernel
def mix_euler(
    mixers: Record, dt: float, omega_b: FloatArray, phi_a: float, theta_a: float, k1: float, k2: float
) -> None:  # fmt: skip
    """Advance roll and pitch by one sample as printed: eq. 1 per angle, rates by eq. 2.

    ``mixers`` (1,) of `MIXER`, ``omega_b`` (3,) [rad/s]; the accelerometer's angles are in rad. The rates are
    singular at pitch 90 deg; there tan and 1/cos are held at those of 89.9 deg.
    """
    state, b = mixers[0], mixers[0].correction
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    phi, theta = state.roll, state.pitch
    tangent = max(min(math.tan(theta), 573.0), -573.0)
    across = q * math.sin(phi) + r * math.cos(phi)
    e_phi, e_theta = phi_a - phi, theta_a - theta
    e_phi -= 2 * math.pi * math.floor(e_phi / (2 * math.pi) + 0.5)
    b[0] += k1 * k2 * e_phi * dt
    b[1] += k1 * k2 * e_theta * dt
    state.roll += (p + tangent * across + k1 * e_phi + b[0]) * dt
    state.pitch += (q * math.cos(phi) - r * math.sin(phi) + k1 * e_theta + b[1]) * dt
