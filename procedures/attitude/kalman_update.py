"""The Kalman filter's covariance: what the errors do between updates, and what one scalar measurement says.

With the attitude error in the level frame, ``psi' = -C b``, ``v' = psi x f_n - C b_f``: the transition over an
update is the unit matrix and six sparse rows, made of the sums of `integrate_sample`.
"""

import math

from procedures.attitude.kalman_state import KalmanSettings, KalmanState
from procedures.attitude.kernel_options import inlined


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
