"""The flight of You and Lee, section 4, and a rest on the bench, with the sensor errors of its table 1.

250 s level, then a bank turn at 1.8 deg/s (90 deg of heading in 50 s), 100 Hz. The paper gives neither speed nor
angle of attack: both are arguments. The air is still, the flight path level, there is no sideslip; the angle of
attack grows with the load, ``a = a0 / cos(bank)``. The Earth does not turn, as in the paper.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog, roll_pitch_of
from procedures.frames import rotation
from procedures.positions import nominal_C_lb
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY

PERIOD_S = 0.01
LEVEL_S = 250.0
TURN_RATE = np.radians(1.8)  # rad/s
ROLL_S = 5.0  # to roll in, and out
GYRO_DEG_H, GYRO_WALK_DEG_H = 50.0, 10.0  # table 1: 1 sigma at the start; random walk per sqrt(h)
FORCE_UG, FORCE_WALK_UG = 140.0, 35.0
AIRSPEED_M_S = 0.3048  # 1 ft/s; the print has "1 ft"
FRD_OF_CUBE = np.diag([1.0, -1.0, -1.0])  # the cube's axes as forward, left, up


def paper_flight(seed: int, turn_s: float = 50.0, speed: float = 200.0, attack_deg: float = 3.0) -> AttitudeLog:
    """Return a flight with the errors of table 1 drawn from ``seed``; every row is scored.

    ``turn_s`` [s] of turning, ``speed`` [m/s], ``attack_deg`` the angle of attack in level flight.
    """
    t: FloatArray = np.arange(0, LEVEL_S + turn_s + PERIOD_S / 2, PERIOD_S)
    course_rate = TURN_RATE * _smooth((t - LEVEL_S) / ROLL_S) * _smooth((LEVEL_S + turn_s - t) / ROLL_S)
    course = np.concatenate(([0.0], np.cumsum(0.5 * (course_rate[1:] + course_rate[:-1]) * PERIOD_S)))
    bank = np.arctan(speed * course_rate / STANDARD_GRAVITY)
    attack = np.radians(attack_deg) / np.cos(bank)
    C_nb = _body(course, bank, attack)
    middle = _body(*(0.5 * (x[1:] + x[:-1]) for x in (course, bank, attack)))
    velocity = speed * np.stack([np.cos(course), np.sin(course), 0 * course], axis=1)
    acceleration = np.diff(velocity, axis=0) / PERIOD_S - [0.0, 0.0, STANDARD_GRAVITY]
    step = np.swapaxes(C_nb[:-1], 1, 2) @ C_nb[1:]  # small: its antisymmetric part is the angle turned
    rate = np.stack([step[:, i, j] - step[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1) / (2 * PERIOD_S)
    force = np.einsum("nji,nj->ni", middle, acceleration)
    rng = np.random.default_rng(seed)
    gyro_error, force_error = sensor_errors(rng, len(rate))
    airspeed = speed * np.cos(attack[1:]) + AIRSPEED_M_S * rng.standard_normal(len(rate))
    roll, pitch = roll_pitch_of(C_nb[1:, 2])
    return AttitudeLog(
        t[1:], rate + gyro_error, force + force_error, airspeed=airspeed, roll=roll, pitch=pitch,
        scored=np.ones(len(rate), bool),
    )  # fmt: skip


def paper_bench(seed: int, position: int, seconds: float = 120.0) -> AttitudeLog:
    """Return a rest in position 1..12 with the errors of table 1, cube x forward, y left, z up."""
    down = -FRD_OF_CUBE @ nominal_C_lb(position)[2]
    t: FloatArray = np.arange(1.0, round(seconds / PERIOD_S) + 1) * PERIOD_S
    gyro_error, force_error = sensor_errors(np.random.default_rng([seed, position]), len(t))
    roll, pitch = (np.full(len(t), angle) for angle in roll_pitch_of(down))
    return AttitudeLog(
        t, gyro_error, force_error - STANDARD_GRAVITY * down, roll=roll, pitch=pitch, scored=t > 60.0
    )  # fmt: skip


def sensor_errors(rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray]:
    """Return gyro [rad/s] and accelerometer [m/s2] errors (n, 3) of table 1: random walks from a random start."""
    walk = np.sqrt(PERIOD_S / 3600)  # of an hour
    gyro, force = (
        start * rng.standard_normal(3) + per_root_h * walk * np.cumsum(rng.standard_normal((n, 3)), axis=0)
        for start, per_root_h in ((GYRO_DEG_H, GYRO_WALK_DEG_H), (FORCE_UG, FORCE_WALK_UG))
    )
    return gyro * RAD_S_PER_DEG_H, force * 1e-6 * STANDARD_GRAVITY


def _smooth(x: FloatArray) -> FloatArray:
    """Return a step from 0 to 1 whose first and second derivatives vanish at both ends."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x * x)


def _body(course: FloatArray, bank: FloatArray, attack: FloatArray) -> FloatArray:
    """Return C_nb (n, 3, 3) of a body flying along ``course``, banked about its path, nose up by ``attack``."""
    zero = np.zeros_like(course)
    about_z = rotation(np.stack([zero, zero, course], axis=1))
    about_x = rotation(np.stack([bank, zero, zero], axis=1))
    C: FloatArray = about_z @ about_x @ rotation(np.stack([zero, attack, zero], axis=1))
    return C
