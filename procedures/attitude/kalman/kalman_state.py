"""The Kalman filter: its state and settings, the covariance over an update, and one scalar measurement.

Errors are those of north-east-down, in this order: attitude 0-2, velocity 3-5 [m/s], gyro bias 6-8 [rad/s], gyro
scale 9-11, accelerometer bias 12-14 [m/s2]; with airspeed also angle of attack 15 and sideslip 16 [rad].

The transition over an update follows from ``psi' = -C b``, ``v' = psi x f_n - C b_f``, with the attitude error psi
in the level frame: the unit matrix and six sparse rows, made of the sums of `integrate_sample`.
"""

import math
from typing import NamedTuple

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kernel_options import Record, inlined

WITHOUT_AIR, WITH_AIR = 15, 17  # states

SLOW = np.dtype((np.record, [  # what changes slowly
    ("gyro_bias", "f8", 3), ("gyro_scale", "f8", 3), ("force_bias", "f8", 3), ("attack", "f8"), ("slip", "f8"),
]))  # fmt: skip
MEMORY = np.dtype((np.record, [
    # sums since the last update, of `SINCE_UPDATE` numbers
    ("velocity_gain", "f8", 3), ("time", "f8"), ("rate_squared", "f8"), ("airspeed_sum", "f8"),
    ("airspeed_rows", "f8"), ("unseen_angle", "f8"), ("unseen_velocity", "f8"), ("rate_integral", "f8", 3),
    ("force_integral", "f8", 3),
    # what is known of rest and heading
    ("mean_rate", "f8", 3), ("mean_force", "f8", 3), ("still_time", "f8"), ("speed", "f8"),
    ("heading_known", "f8"), ("started", "f8"), ("last_rate", "f8", 3), ("at_rest", "f8"),
    ("velocity_known", "f8"), ("newest", "f8"),
    # how the velocity moves about zero without aid: its integral that fades, the sums of that squared, of time,
    # and of the velocity squared
    ("drift", "f8", 2), ("drift_squared", "f8"), ("drift_time", "f8"), ("speed_squared", "f8"),
    # sums over the span that rest is judged by
    ("unseen_run", "f8"),  # rad: the unseen angle of the updates running before this one
    ("span_time", "f8"), ("span_rate", "f8", 3), ("span_force", "f8", 3),
]))  # fmt: skip
SINCE_UPDATE = 15
REMEMBERED_UPDATES = 64  # updates that are remembered: three seconds, for fixes that come late


class KalmanState(NamedTuple):
    """The filter's memory; arrays are changed in place.

    ``C_nb`` (3, 3); ``v_n`` (3,) [m/s]; ``slow`` (1,) of `SLOW`; ``P`` (n, n); ``sums`` (3, 6), the integrals of
    C_nb and of C_nb diag(rate); ``memory`` (1,) of `MEMORY`, whose numbers are ``flat`` (m,); ``past`` (64, 5), a
    ring of the last updates: seconds, velocity gained (3,) [m/s], angle turned about down [rad]. The others are
    scratch.
    """

    C_nb: FloatArray
    v_n: FloatArray
    slow: Record
    P: FloatArray
    sums: FloatArray
    memory: Record
    flat: FloatArray
    past: FloatArray
    gained: FloatArray
    held: FloatArray
    dx: FloatArray
    A: FloatArray
    AP: FloatArray
    H: FloatArray
    PH: FloatArray
    at: IntArray


def new_state(with_air: bool) -> KalmanState:
    """Return a state before its first sample."""
    n = WITH_AIR if with_air else WITHOUT_AIR
    memory = np.zeros(1, MEMORY)
    return KalmanState(
        C_nb=np.eye(3), v_n=np.zeros(3), slow=np.zeros(1, SLOW), P=np.zeros((n, n)), sums=np.zeros((3, 6)),
        memory=memory, flat=memory.view(np.float64), past=np.zeros((REMEMBERED_UPDATES, 5)), gained=np.zeros(5),
        held=np.zeros((4, 3)), dx=np.zeros(n),
        A=np.zeros((6, n)), AP=np.zeros((6, n)), H=np.zeros(7), PH=np.zeros(n), at=np.arange(7, dtype=np.int64),
    )  # fmt: skip


@inlined
def propagate(s: KalmanState, c: KalmanSettings) -> None:
    """Carry the covariance over the time since the last update."""
    P, A, AP, sums, memory = s.P, s.A, s.AP, s.sums, s.memory[0]
    n = len(s.dx)
    x, y, z = memory.velocity_gain
    if memory.at_rest > 0.0:  # what is across gravity is a tilt, and no acceleration that a heading would turn
        x = y = 0.0
    A[3, 1], A[3, 2], A[4, 0], A[4, 2], A[5, 0], A[5, 1] = z, -y, -z, x, y, -x
    for i in range(3):
        for j in range(6):
            A[i, 6 + j] = -sums[i, j]
        for j in range(3):
            A[3 + i, 12 + j] = -sums[i, j]
    for i in range(3):
        j1, j2 = (i + 1) % 3, (i + 2) % 3
        for j in range(n):
            AP[i, j] = (
                A[i, 6] * P[6, j] + A[i, 7] * P[7, j] + A[i, 8] * P[8, j]
                + A[i, 9] * P[9, j] + A[i, 10] * P[10, j] + A[i, 11] * P[11, j]
            )  # fmt: skip
            AP[3 + i, j] = (
                A[3 + i, j1] * P[j1, j] + A[3 + i, j2] * P[j2, j]
                + A[3 + i, 12] * P[12, j] + A[3 + i, 13] * P[13, j] + A[3 + i, 14] * P[14, j]
            )  # fmt: skip
    for i in range(6):
        for j in range(i + 1):
            both = 0.0
            if j < 3:
                for k in range(6, 12):
                    both += AP[i, k] * A[j, k]
            else:
                for k in range(3):
                    both += AP[i, k] * A[j, k]
                for k in range(12, 15):
                    both += AP[i, k] * A[j, k]
            P[i, j] += AP[i, j] + AP[j, i] + both
            P[j, i] = P[i, j]
        for j in range(6, n):
            P[i, j] += AP[i, j]
            P[j, i] = P[i, j]
    _grow(s, c)


@inlined
def _grow(s: KalmanState, c: KalmanSettings) -> None:
    """Add what went on unseen, and let the angle of attack and the sideslip go back to zero."""
    P, memory = s.P, s.memory[0]
    T = memory.time
    at_rest = memory.at_rest > 0.0
    gyro_noise = min(c.rest_gyro_noise, c.gyro_noise) if at_rest else c.gyro_noise
    unseen = memory.unseen_angle  # one error as long as it goes on: its sum grows with time, not with its root
    angle = gyro_noise**2 * T + c.gyro_noise_per_rate**2 * memory.rate_squared
    angle += unseen * (unseen + 2.0 * memory.unseen_run)
    memory.unseen_run = memory.unseen_run + unseen if unseen > 0.0 else 0.0
    force_noise = c.rest_force_noise if at_rest else c.force_noise
    bias_walk = min(c.rest_bias_walk, c.gyro_bias_walk) if at_rest else c.gyro_bias_walk
    speed = force_noise**2 * T + memory.unseen_velocity**2
    turn = memory.rate_integral
    turned = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
    bias = bias_walk**2 * T + c.unseen_rate**2 * turned  # after a radian it points elsewhere
    for i in range(3):
        P[i, i] += angle
        P[3 + i, 3 + i] += speed
        P[6 + i, 6 + i] += bias
        P[12 + i, 12 + i] += c.force_bias_walk**2 * T
    if len(s.dx) > 15:
        left = math.exp(-T / c.attack_s)
        s.slow[0].attack *= left
        _fade(s, 15, left, c.attack_std)
        left = math.exp(-T / c.slip_s)
        s.slow[0].slip *= left
        _fade(s, 16, left, c.slip_std)


@inlined
def _fade(s: KalmanState, i: int, left: float, std: float) -> None:
    """Carry the covariance of first-order Gauss-Markov state ``i``; ``left`` is what remains of it."""
    for j in range(len(s.dx)):
        s.P[i, j] *= left
        s.P[j, i] = s.P[i, j]
    s.P[i, i] = left * s.P[i, i] + std * std * (1.0 - left * left)


@inlined
def measure(s: KalmanState, terms: int, error: float, variance: float, believed: float) -> None:
    """Take in a scalar: ``error`` = what the state says minus what was measured.

    Its derivative by the states ``s.at[:terms]`` is ``s.H[:terms]``. Beyond ``believed`` sigma the measurement is
    given the variance that puts it there: an outlier pulls, but no more than a bad measurement would.
    """
    P, PH, H, at, dx = s.P, s.PH, s.H, s.at, s.dx
    n = len(dx)
    for i in range(n):
        PH[i] = 0.0
    for k in range(terms):
        h, row = H[k], at[k]
        error -= h * dx[row]
        for i in range(n):
            PH[i] += P[row, i] * h
    own = 0.0
    for k in range(terms):
        own += H[k] * PH[at[k]]
    inverse = 1.0 / max(own + variance, error * error / (believed * believed))
    for i in range(n):
        row = PH[i]
        dx[i] += row * inverse * error
        for j in range(n):  # the whole square: it stays symmetric to the last bit, and runs in vectors
            P[i, j] -= (row * PH[j]) * inverse
