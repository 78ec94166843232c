"""Velocity aids of the mixing law: forward speed, and the velocity filter (11)-(14) of You and Lee."""

import math

from procedures.arrays import FloatArray
from procedures.attitude.complementary_kernels import (
    PRINTED,
    PRINTED_FILTER,
    VECTOR,
    VECTOR_SPEED,
    MixingLaw,
    mix_euler,
    mix_vector,
)
from procedures.attitude.kernel_options import Record, kernel

SMOOTH_S = 0.5  # of the rates that open the gate
LEARN_S = 20.0  # over which the angle of attack is remembered
# You and Lee, section 4: variances per sample; INITIAL_VELOCITY_VARIANCE is not printed, 100 does best
VELOCITY_PROCESS_VARIANCE, AIRSPEED_VARIANCE, INITIAL_VELOCITY_VARIANCE = 2.0e-9, 100.0, 100.0


@kernel
def open_gate(mixers: Record, law: MixingLaw, dt: float, omega_b: FloatArray, speed: float) -> bool:
    """Take in ``omega_b`` (3,) [rad/s] and a speed [m/s]; return whether it turns faster than the gate."""
    aid = mixers[0]
    share = min(dt / SMOOTH_S, 1.0)
    smooth = aid.smooth_rate
    for i in range(3):
        smooth[i] += share * (omega_b[i] - smooth[i])
    if speed == speed:
        aid.airspeed = speed
    aid.elapsed_s += dt
    return bool(smooth[0] * smooth[0] + smooth[1] * smooth[1] + smooth[2] * smooth[2] > law.gate * law.gate)


@kernel
def mix_speed(
    mixers: Record, law: MixingLaw, dt: float, omega_b: FloatArray, f_b: FloatArray, speed: float
) -> None:
    """Advance the law on the gravity vector, aided by forward speed and the remembered angle of attack.

    ``omega_b`` (3,) [rad/s], ``f_b`` (3,) [m/s2], ``speed`` [m/s], nan where there is none.
    Taken off while the gate is open: omega x (u, 0, w), u = V cos a, w = V sin a. While it is closed nothing is,
    since V times a yaw rate's bias would tilt a level flight; there the pitch is the angle of attack.
    """
    aid = mixers[0]
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    x, y, z = f_b[0], f_b[1], f_b[2]
    if open_gate(mixers, law, dt, omega_b, speed):
        u, w = aid.airspeed * math.cos(aid.attack), aid.airspeed * math.sin(aid.attack)
        aid.velocity[0], aid.velocity[2] = u, w
        x, y, z = x - q * w, y - r * u + p * w, z + q * u
    elif aid.airspeed > 1.0:
        aid.learned_s = min(aid.learned_s + dt, LEARN_S)
        pitch = math.asin(max(-1.0, min(1.0, -aid.down[0])))
        aid.attack += min(dt / aid.learned_s, 1.0) * (pitch - aid.attack)
    aid.gravity[0], aid.gravity[1], aid.gravity[2] = x, y, z
    start = 1.0 / (aid.elapsed_s + 0.1)  # a running mean first, the gain once that is the faster
    mix_vector(mixers, dt, omega_b, aid.gravity, max(law.k1, start), law.k2)


@kernel
def paper_angles(f_b: FloatArray, velocity: FloatArray, omega_b: FloatArray, g: float) -> tuple[float, float]:
    """Return phi_a and theta_a [rad]: You and Lee (14), with v = w = 0 (10).

    Parameters
    ----------
    f_b, velocity, omega_b : (3,), m/s2, m/s, rad/s
        Specific force, velocity and rate in b.
    g : m/s2
    """
    u, v, w = velocity[0], velocity[1], velocity[2]
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    theta = math.asin(max(-1.0, min(1.0, (f_b[0] + r * v - q * w) / g)))
    phi = math.asin(max(-1.0, min(1.0, (-f_b[1] + r * u - p * w) / (g * max(math.cos(theta), 1e-3)))))
    return phi, theta


@kernel
def filter_velocity(
    mixers: Record, dt: float, omega_b: FloatArray, f_b: FloatArray, speed: float, g: float
) -> None:
    """Advance the velocity filter by one sample, ``omega_b`` (3,) [rad/s] and ``f_b`` (3,) [m/s2].

    You and Lee (11), (12), with the attitude before the sample.
    """
    aid, phi, theta = mixers[0], mixers[0].roll, mixers[0].pitch
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    velocity, P = aid.velocity, aid.covariance
    u, v, w = velocity[0], velocity[1], velocity[2]
    velocity[0] = u + (r * v - q * w + f_b[0] - g * math.sin(theta)) * dt
    velocity[1] = v + (-r * u + p * w + f_b[1] + g * math.sin(phi) * math.cos(theta)) * dt
    velocity[2] = w + (q * u - p * v + f_b[2] + g * math.cos(phi) * math.cos(theta)) * dt
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
        P[i, i] += VELOCITY_PROCESS_VARIANCE
    if speed == speed:
        variance, error = P[0, 0] + AIRSPEED_VARIANCE, speed - velocity[0]
        for i in (2, 1, 0):  # the first row, which all are corrected by, as the last
            gain = P[i, 0] / variance
            velocity[i] += gain * error
            for j in range(3):
                P[i, j] -= gain * P[0, j]


@kernel
def mix_paper(
    mixers: Record, law: MixingLaw, dt: float, omega_b: FloatArray, f_b: FloatArray, speed: float
) -> None:
    """Advance the Euler form as printed, aided by forward speed alone (10) or by the velocity filter (11)-(14).

    ``omega_b`` (3,) [rad/s], ``f_b`` (3,) [m/s2], ``speed`` [m/s], nan where there is none. While the gate is
    closed the filter's v and w are held and u follows the airspeed.
    """
    aid = mixers[0]
    is_open = open_gate(mixers, law, dt, omega_b, speed)
    if law.form == PRINTED_FILTER and is_open:
        filter_velocity(mixers, dt, omega_b, f_b, speed, law.g)
    else:
        aid.velocity[0] = aid.airspeed
    phi_a, theta_a = paper_angles(f_b, aid.velocity, omega_b, law.g)
    mix_euler(mixers, dt, omega_b, phi_a, theta_a, law.k1, law.k2)


@kernel
def mix_log(
    mixers: Record, law: MixingLaw, dt: FloatArray, omega_b: FloatArray, f_b: FloatArray, speed: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Run a law over a log.

    Parameters
    ----------
    mixers, dt, omega_b, f_b, speed : (1,) of `MIXER`; (n,), s; (n, 3), rad/s; (n, 3), m/s2; (n,), m/s
        The state, changed in place, and the samples in b.
    out : (n, 3)
        The unit down vector in b of every row; in Euler angles (n, 2), its roll and pitch [rad].
    """
    mixer = mixers[0]
    for i in range(len(dt)):
        if law.form == VECTOR:
            mix_vector(mixers, dt[i], omega_b[i], f_b[i], law.k1, law.k2)
        elif law.form == VECTOR_SPEED:
            mix_speed(mixers, law, dt[i], omega_b[i], f_b[i], speed[i])
        else:
            mix_paper(mixers, law, dt[i], omega_b[i], f_b[i], speed[i])
        if law.form < PRINTED:
            out[i, 0], out[i, 1], out[i, 2] = mixer.down[0], mixer.down[1], mixer.down[2]
        else:
            out[i, 0], out[i, 1] = mixer.roll, mixer.pitch
