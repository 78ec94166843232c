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
from procedures.attitude.kernel_options import Record, inlined
from procedures.units import STANDARD_GRAVITY

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


class KalmanSettings(NamedTuple):
    """What the Kalman filter assumes; SI and radians. The filter: ``docs/explanation/attitude.md``.

    Densities are 1 sigma per root of a second: of angle for gyros, of velocity for accelerometers; a measurement's
    times the root of the seconds that it is averaged over is its sigma.
    """

    update_s: float = 0.05  # between updates; the attitude is integrated at every sample
    gravity: float = STANDARD_GRAVITY
    gyro_noise: float = 1e-4  # rad/sqrt(s)
    gyro_noise_per_rate: float = 1.5e-3  # of the rate, 1/sqrt(1/s): scale and axes while turning
    gyro_bias_walk: float = 1e-5  # rad/s/sqrt(s)
    gyro_bias_std: float = 0.03  # rad/s, 1.7 deg/s: of a MEMS gyro switched on
    gyro_scale_std: float = 2e-3
    force_noise: float = 0.1  # m/s/sqrt(s): vibration, lever arm, gusts as felt
    force_bias_std: float = 0.05  # m/s2, 5 mg
    force_bias_walk: float = 1e-4  # m/s2/sqrt(s)
    tilt_std: float = math.radians(15.0)  # of the first specific force taken for the vertical
    velocity_std: float = 1.0  # m/s, at the start
    velocity_std_per_speed: float = 0.1
    speed_noise: float = 0.45  # m/s*sqrt(s): no aid; the velocity is about zero
    speed_s: float = 0.32  # no aid: for so long the velocity goes on, once it is known how much there is of it
    airspeed_noise: float = 1.0  # m/s*sqrt(s): gusts along the flight path
    gust_noise: float = 1.0  # m/s*sqrt(s): gusts across it
    climb_noise: float = 10.0  # m/s*sqrt(s): vertical speed is about zero, weakly
    climb_noise_per_speed: float = 0.4
    attack_std: float = math.radians(4.0)
    attack_s: float = 100.0
    slip_std: float = math.radians(1.0)
    slip_s: float = 20.0
    velocity_fix_std: float = 0.1  # m/s: GNSS
    fix_latency: float = 0.0  # s by which a fix is older than the row that it stands at
    heading_std: float = math.radians(2.0)  # of a heading given
    course_std: float = math.radians(15.0)  # of the first course taken for the heading
    course_speed: float = 3.0  # m/s, above which a course says something
    rest_rate: float = math.radians(1.0)  # rad/s: rates that vary by less may be rest
    rest_force: float = 0.3  # m/s2
    rest_speed: float = 1.0  # m/s, above which an aid denies rest
    rest_s: float = 1.5  # for so long
    cruise_std: float = 0.0  # m/s: above zero, rest may be a steady cruise; the velocity then restarts at it
    rest_velocity_noise: float = 0.01  # m/s*sqrt(s)
    rest_force_noise: float = 0.03  # m/s/sqrt(s), of accelerometers that nothing shakes
    rest_bias_walk: float = 1e-4  # rad/s/sqrt(s), of gyros that nothing moves
    rest_gyro_noise: float = math.inf  # rad/sqrt(s): their own noise, if it is less
    unseen_rate: float = 0.0  # rad/s, part of the biases that turns as the unit does: the Earth's
    rest_rate_noise: float = 2.5e-4  # rad/s*sqrt(s); a minute of it is half the Earth rate
    rate_limit: float = math.inf  # rad/s: the gyros' range; at it they are saturated
    force_limit: float = math.inf  # m/s2
    nominal_s: float = 0.01  # the usual interval between samples
    earth_north: float = 0.0  # rad/s, of the Earth's rate
    earth_down: float = 0.0
    believed_sigma: float = 3.0  # a measurement further off counts as if it stood there


AIDED_SETTINGS = KalmanSettings()

# Without aid the tilt is what the last seconds of specific force say: a bias may drift, as MEMS ones do in
# motion, at no cost, and the scale factor's share of fast motion counts more than anything slow. All noises by one
# factor leave the attitude as it is: that factor makes sigma what the error is.
UNAIDED_SETTINGS = KalmanSettings(
    gyro_noise=5e-5, gyro_noise_per_rate=7.5e-4, gyro_bias_walk=2.5e-4, gyro_scale_std=2.5e-3, force_noise=0.025,
    force_bias_std=0.02, force_bias_walk=2e-5, velocity_std=0.5, speed_noise=0.22, rest_velocity_noise=3e-3,
)  # fmt: skip


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
