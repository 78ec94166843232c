"""A car's drive with exact truth, for tests."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog, roll_pitch_of
from procedures.frames import rotation

G = 9.80665
BIAS = np.array([2e-3, -1e-3, 3e-3])  # rad/s


def driving(
    seed: int = 2, seconds: float = 100.0, dt: float = 0.01, bias: FloatArray = BIAS
) -> tuple[AttitudeLog, FloatArray]:
    """A car that starts, turns both ways and brakes, nose along its path; its down vectors next to the log."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, seconds + dt / 2, dt)
    under_way = t > 15
    speed = 15 * np.clip((t - 10) / 5, 0, 1) + 2 * np.sin(0.3 * (t - 15)) * under_way
    heading = 1.0 + np.cumsum(np.where(under_way, 0.25 * np.sin(0.2 * (t - 15)), 0.0)) * dt
    pitch = 0.05 * np.sin(0.1 * (t - 15)) * under_way
    zero = 0 * t
    C = rotation(np.stack([zero, zero, heading], 1)) @ rotation(np.stack([zero, pitch, zero], 1))
    velocity = C[:, :, 0] * speed[:, None]
    step = np.swapaxes(C[:-1], 1, 2) @ C[1:]
    rate = np.stack([step[:, i, j] - step[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], 1) / (2 * dt)
    middle = 0.5 * (C[1:] + C[:-1])
    force = np.einsum("nji,nj->ni", middle, np.diff(velocity, axis=0) / dt - [0, 0, G])
    n = len(rate)
    rate += bias + 1e-4 / np.sqrt(dt) * rng.standard_normal((n, 3))
    force += 0.01 / np.sqrt(dt) * rng.standard_normal((n, 3))
    fixes = np.where((np.arange(n) % 20 == 19)[:, None], velocity[1:] + 0.05 * rng.standard_normal((n, 3)), np.nan)
    return AttitudeLog(t[1:], rate, force, speed[1:] + 0.1 * rng.standard_normal(n), fixes), C[1:, 2]


def with_truth(seconds: float = 200.0) -> AttitudeLog:
    """A drive of sensors without bias, with truth."""
    log, down = driving(seconds=seconds, bias=np.zeros(3))
    roll, pitch = roll_pitch_of(down)
    return AttitudeLog(log.t, log.omega_b, log.f_b, log.airspeed, log.velocity, roll=roll, pitch=pitch)
