"""Velocity aids of the complementary filter: forward speed, the whole of (9), and the velocity filter (11)-(14).

Equation numbers are those of You and Lee; `observability` evaluates (13), on which the velocity filter depends.
"""

import math
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_kernels import (
    PRINTED,
    PRINTED_FILTER,
    PRINTED_GNSS,
    PRINTED_RATE,
    VECTOR,
    VECTOR_SPEED,
    MixerSettings,
    mix_euler,
    mix_vector,
)
from procedures.attitude.kernel_options import Record, kernel

SMOOTH_S = 0.5  # of the rates that open the gate
LEARN_S = 20.0  # over which the angle of attack is remembered
DERIVATIVE_S = 0.3  # over which a velocity is smoothed before it is differentiated
STEADY_S = 5.0  # over which a change of speed is smoothed that is to be shown
STALE_S = 3.0  # without a velocity, after which it is no longer taken to change
MIN_SPEED = 1.0  # m/s, above which the pitch of level flight is an angle of attack
# You and Lee, section 4: variances per sample; INITIAL_VELOCITY_VARIANCE is not printed, up to 100 makes no odds
VELOCITY_PROCESS_VARIANCE, AIRSPEED_VARIANCE, INITIAL_VELOCITY_VARIANCE = 2.0e-9, 100.0, 100.0


@kernel
def take_velocity(mixers: Record, dt: float, level: FloatArray) -> None:
    """Take in a velocity ``level`` (3,) [m/s], nan where there is none, and what it changes by.

    The derivative is of the velocity smoothed over `DERIVATIVE_S`: its integral is the velocity gained, so that
    the filter, slower than that, sees the noise of a speed and not that of a derivative.
    """
    aid = mixers[0]
    aid.since_s += dt
    if level[0] == level[0]:
        share = aid.since_s / (DERIVATIVE_S + aid.since_s)
        for i in range(3):
            if aid.known == 0.0 or math.isnan(aid.smooth_level[i]):
                aid.smooth_level[i] = level[i]
            step = share * (level[i] - aid.smooth_level[i])
            aid.smooth_level[i] += step
            aid.level_rate[i] = step / max(aid.since_s, 1e-6)
            aid.level[i] = level[i]
        aid.airspeed, aid.known, aid.since_s = level[0], 1.0, 0.0
    elif aid.since_s > STALE_S:
        aid.level_rate[:] = 0.0
    aid.steady_rate += min(dt / STEADY_S, 1.0) * (aid.level_rate[0] - aid.steady_rate)


@kernel
def open_gate(
    mixers: Record, settings: MixerSettings, dt: float, omega_b: FloatArray, f_b: FloatArray, level: FloatArray
) -> bool:
    """Take in a sample; return whether it turns faster than the gate.

    Parameters
    ----------
    mixers, dt : (1,) of `MIXER`; s
    omega_b, f_b, level : (3,), rad/s; m/s2; m/s, nan where there is none
    """
    aid = mixers[0]
    share = min(dt / SMOOTH_S, 1.0)
    smooth = aid.smooth_rate
    for i in range(3):
        smooth[i] += share * (omega_b[i] - smooth[i])
    load = math.sqrt(f_b[0] * f_b[0] + f_b[1] * f_b[1] + f_b[2] * f_b[2]) / settings.g
    aid.load += share * (load - aid.load)
    take_velocity(mixers, dt, level)
    aid.elapsed_s += dt
    return bool(
        smooth[0] * smooth[0] + smooth[1] * smooth[1] + smooth[2] * smooth[2] > settings.gate * settings.gate
    )


@kernel
def learn_attack(mixers: Record, dt: float, pitch: float) -> None:
    """Remember the ``pitch`` [rad] of straight and level flight: it is the angle of attack."""
    aid = mixers[0]
    if aid.airspeed > MIN_SPEED:
        aid.learned_s = min(aid.learned_s + dt, LEARN_S)
        aid.attack += min(dt / aid.learned_s, 1.0) * (pitch - aid.attack)


@kernel
def mix_speed(
    mixers: Record, settings: MixerSettings, dt: float, omega_b: FloatArray, f_b: FloatArray, level: FloatArray
) -> None:
    """Advance the filter on the gravity vector, aided by forward speed and the remembered angle of attack.

    Corrected while the gate is open: omega x (u, 0, w), u = V cos a, w = V sin a. While it is closed nothing is,
    since V times a yaw rate's bias would tilt a level flight; there the pitch is the angle of attack.

    Parameters
    ----------
    mixers, dt : (1,) of `MIXER`; s
    omega_b, f_b, level : (3,), rad/s; m/s2; m/s, the speed first, nan where there is none
    """
    aid = mixers[0]
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    x, y, z = f_b[0], f_b[1], f_b[2]
    if open_gate(mixers, settings, dt, omega_b, f_b, level):
        u, w = aid.airspeed * math.cos(aid.attack), aid.airspeed * math.sin(aid.attack)
        aid.velocity[0], aid.velocity[2] = u, w
        x, y, z = x - q * w, y - r * u + p * w, z + q * u
    else:
        aid.velocity[0] = aid.velocity[2] = 0.0
        learn_attack(mixers, dt, math.asin(max(-1.0, min(1.0, -aid.down[0]))))
    aid.gravity[0], aid.gravity[1], aid.gravity[2] = x, y, z
    start = 1.0 / (aid.elapsed_s + 0.1)  # a running mean first, the gain once that is the faster
    mix_vector(mixers, dt, omega_b, aid.gravity, max(settings.k1, start), settings.k2)


@kernel
def angles_of_gravity(f_b: FloatArray, x: float, y: float, g: float) -> tuple[float, float]:
    """Return phi_a and theta_a [rad] of ``f_b`` (3,) less the motion's acceleration x, y [m/s2], in b: (9)."""
    theta = math.asin(max(-1.0, min(1.0, (f_b[0] - x) / g)))
    phi = math.asin(max(-1.0, min(1.0, (y - f_b[1]) / (g * max(math.cos(theta), 1e-3)))))
    return phi, theta


@kernel
def acceleration_by_rates(velocity: FloatArray, omega_b: FloatArray) -> tuple[float, float]:
    """Return x, y of ``omega_b`` x ``velocity`` (3,) [m/s2]: what (14) takes off; with v = w = 0 nearly (10)."""
    u, v, w = velocity[0], velocity[1], velocity[2]
    p, q, r = omega_b[0], omega_b[1], omega_b[2]
    return q * w - r * v, r * u - p * w


@kernel
def whole_acceleration(mixers: Record, omega_b: FloatArray) -> tuple[float, float]:
    """Return x, y of the acceleration [m/s2], body axes, by a GNSS velocity: all of (9); ``omega_b`` (3,) [rad/s].

    Where the heading is known the velocity is forward, right, down of it; its acceleration is taken into the body
    by the filter's own angles. Where it is not (nan to the right) nothing slips sideways, v = 0, and the vertical
    speed says w by those angles: to take the course for the heading would leave w out, and err as (10) does.
    """
    aid = mixers[0]
    rate, level = aid.level_rate, aid.level
    sine, cosine = math.sin(aid.roll), math.cos(aid.roll)
    climb, along = math.sin(aid.pitch), max(math.cos(aid.pitch), 1e-3)
    if math.isnan(level[1]):
        w = (level[0] * climb + level[2]) / (along * max(cosine, 0.1))
        aid.velocity[2] = max(-0.5 * level[0], min(0.5 * level[0], w))
        aid.velocity[0] = math.sqrt(level[0] ** 2 - aid.velocity[2] ** 2)
        x, y = acceleration_by_rates(aid.velocity, omega_b)
        return x + rate[0], y
    turning = (omega_b[1] * sine + omega_b[2] * cosine) / along
    ahead, right = rate[0] - turning * level[1], rate[1] + turning * level[0]
    below = climb * ahead + along * rate[2]
    return along * ahead - climb * rate[2], cosine * right + sine * below


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
    mixers: Record, settings: MixerSettings, dt: float, omega_b: FloatArray, f_b: FloatArray, level: FloatArray
) -> None:
    """Advance the Euler form as printed: forward speed (10), the whole of (9), or the velocity filter (11)-(14).

    While the gate is closed the filter's v and w are held and u follows the airspeed. Before it was first open
    v and w are what level flight at the remembered angle of attack says: 0, u tan a.

    Parameters
    ----------
    mixers, dt : (1,) of `MIXER`; s
    omega_b, f_b, level : (3,), rad/s; m/s2; m/s, nan where there is none
    """
    aid = mixers[0]
    is_open = open_gate(mixers, settings, dt, omega_b, f_b, level)
    if settings.form == PRINTED_FILTER and is_open:
        aid.has_turned = 1.0
        filter_velocity(mixers, dt, omega_b, f_b, level[0], settings.g)
    else:
        aid.velocity[0] = aid.airspeed
        if not is_open:
            learn_attack(mixers, dt, aid.pitch)
        if settings.form == PRINTED_FILTER and aid.has_turned == 0.0:
            aid.velocity[2] = aid.airspeed * math.tan(aid.attack)
    if settings.form == PRINTED_GNSS:
        x, y = whole_acceleration(mixers, omega_b)
    else:
        x, y = acceleration_by_rates(aid.velocity, omega_b)
    if settings.form == PRINTED_RATE:
        x += aid.level_rate[0]
    phi_a, theta_a = angles_of_gravity(f_b, x, y, settings.g)
    mix_euler(mixers, dt, omega_b, phi_a, theta_a, settings.k1, settings.k2)


@kernel
def mix_log(
    mixers: Record, settings: MixerSettings, dt: FloatArray, omega_b: FloatArray, f_b: FloatArray,
    level: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Run a filter over a log.

    Parameters
    ----------
    mixers, dt, omega_b, f_b : (1,) of `MIXER`; (n,), s; (n, 3), rad/s; (n, 3), m/s2
        The state, changed in place, and the samples in b.
    level : (n, 3), m/s
        The velocity, forward, right and down of the heading; a speed along body x alone stands first. Nan where
        there is none at a row.
    out : (n, 3)
        The unit down vector in b of every row; in Euler angles (n, 2), its roll and pitch [rad].
    """
    mixer = mixers[0]
    for i in range(len(dt)):
        if settings.form == VECTOR:
            mix_vector(mixers, dt[i], omega_b[i], f_b[i], settings.k1, settings.k2)
        elif settings.form == VECTOR_SPEED:
            mix_speed(mixers, settings, dt[i], omega_b[i], f_b[i], level[i])
        else:
            mix_paper(mixers, settings, dt[i], omega_b[i], f_b[i], level[i])
        if settings.form < PRINTED:
            out[i, 0], out[i, 1], out[i, 2] = mixer.down[0], mixer.down[1], mixer.down[2]
        else:
            out[i, 0], out[i, 1] = mixer.roll, mixer.pitch


RATE_AVERAGING_S = 1.0  # s, of the rates of which (13) is taken


@dataclass(frozen=True, slots=True)
class Observability:
    """Over the rows at which the filter ran (``open_s`` seconds of the log).

    ``determinant_rms`` [rad3/s3] of (13); ``rank_3`` is the share of those rows at which it stands above what
    rates of the gate's size would give. Where it does not, velocity along the turn axis is dead reckoning.
    """

    open_s: float
    determinant_rms: float
    rank_3: float


def determinant(rate: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the determinant (n,) of (13) for ``rate`` (n, 3) [rad/s] and its derivative ``slope`` (n, 3).

    It is ``p (q^2 + r^2) + q dr/dt - r dq/dt``.
    """
    p, q, r = np.moveaxis(rate, -1, 0)
    found: FloatArray = p * (q * q + r * r) + q * slope[..., 2] - r * slope[..., 1]
    return found


def observability(log: AttitudeLog, gate: float) -> Observability:
    """Evaluate (13) along a log, on rates averaged over a second, where they exceed the gate [rad/s]."""
    rows = max(round(RATE_AVERAGING_S / log.nominal), 1)
    kernel = np.ones(rows) / rows
    rate = np.stack([np.convolve(log.omega_b[:, i], kernel, "same") for i in range(3)], axis=1)
    slope = np.gradient(rate, log.t, axis=0) if len(log.t) > 2 else np.zeros_like(rate)
    is_open = np.linalg.norm(rate, axis=1) > gate
    found = determinant(rate, slope)[is_open]
    if not len(found):
        return Observability(0.0, 0.0, 0.0)
    above = np.abs(found) > 2 * gate**3
    return Observability(
        float(log.intervals[is_open].sum()), float(np.sqrt(np.mean(found**2))), float(np.mean(above))
    )
