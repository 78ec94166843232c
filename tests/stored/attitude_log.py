"""A drive of 40 s with a rest, turns, braking and climbing, at 50 Hz, made without `procedures`."""

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.attitude.attitude_log import AttitudeLog

PERIOD, G = 0.02, 9.80665


def drive(seconds: float = 40.0, rest: float = 6.0, fix_s: float = 0.2) -> AttitudeLog:
    """Return a log with airspeed, velocity each ``fix_s`` and truth; gyros' biases 2, -1 and 3 mrad/s."""
    rng, n = np.random.default_rng(5), round(seconds / PERIOD)
    t = PERIOD * np.arange(n + 1)
    on = np.clip((t - rest) / 2, 0.0, 1.0)
    roll = on * 0.35 * np.sin(0.4 * t)
    pitch = on * 0.12 * np.sin(0.23 * t + 0.3)
    yaw = on * 0.8 * np.sin(0.15 * (t - rest))
    speed = on * (15 + 6 * np.sin(0.3 * (t - rest)))
    C_nb = Rotation.from_euler("ZYX", np.stack((yaw, pitch, roll), axis=1))
    velocity = C_nb.apply(np.stack((speed, 0 * t, 0 * t), axis=1))
    omega = (C_nb[:-1].inv() * C_nb[1:]).as_rotvec() / PERIOD
    force_n = np.diff(velocity, axis=0) / PERIOD - [0.0, 0.0, G]
    force = C_nb[1:].inv().apply(force_n)
    omega = omega + [2e-3, -1e-3, 3e-3] + 5e-4 * rng.standard_normal((n, 3))
    force = force + [0.02, -0.03, 0.01] + 0.03 * rng.standard_normal((n, 3))
    every = round(fix_s / PERIOD)
    fixes = np.full((n, 3), np.nan)
    fixes[every - 1 :: every] = (velocity[1:] + 0.05 * rng.standard_normal((n, 3)))[every - 1 :: every]
    air = np.full(n, np.nan)
    air[4::5] = (speed[1:] + 0.3 * rng.standard_normal(n))[4::5]
    return AttitudeLog(t[1:], omega, force, airspeed=air, velocity=fixes, roll=roll[1:], pitch=pitch[1:])
