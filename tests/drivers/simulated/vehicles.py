"""Vehicles that drive, fly and roll, with exact truth: logs without any velocity, for the attitude without aid.

Each is speed, heading, pitch and roll along time, drawn from a seed; the nose lies along the path but for an angle
of attack. Sensors are means over the interval; the Earth neither turns nor is round.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog, roll_pitch_of
from procedures.frames import rotation
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY

PERIOD_S = 0.01
G = STANDARD_GRAVITY


class Grade(NamedTuple):
    """1 sigma of a sensor's errors, SI: bias and walk, white noise per root of a second, scale factor."""

    gyro_bias: float
    gyro_walk: float
    gyro_noise: float
    gyro_scale: float
    force_bias: float
    force_noise: float


MEMS = Grade(3e-3, 2e-5, 1e-4, 2e-3, 0.02, 1e-3)
FOG = Grade(3 * RAD_S_PER_DEG_H, 1e-7, 6e-6, 1e-4, 0.005, 5e-4)


class Motion(NamedTuple):
    """A path: ``speed`` [m/s] along ``heading`` [rad] and ``climb`` [rad]; ``pitch``, ``roll`` [rad] of the body.

    ``shaken`` (n, 3) [m/s2] is what vibration adds to the specific force.
    """

    speed: FloatArray
    heading: FloatArray
    climb: FloatArray
    pitch: FloatArray
    roll: FloatArray
    shaken: FloatArray


def town_car(rng: np.random.Generator, t: FloatArray) -> Motion:
    """Starts, stops and corners: 10 to 40 s between two of them, 1 to 2.5 m/s2, hills of 3 deg."""
    speed, turn = np.zeros(len(t)), np.zeros(len(t))
    now, v = rng.uniform(10, 20), 0.0
    while now < t[-1]:
        goal = 0.0 if v > 0 and rng.random() < 0.4 else rng.uniform(6, 16)
        takes = abs(goal - v) / rng.uniform(1.0, 2.5)
        speed += (goal - v) * eased((t - now) / takes)
        now += takes
        v = goal
        stay = rng.uniform(5, 30)
        if v > 0 and rng.random() < 0.7:
            corner, lasts = rng.choice([-1, 1]) * rng.uniform(0.4, 1.7), rng.uniform(3, 6) * v / 8
            turn += corner / lasts * pulse(t, now + 2, lasts)
            stay += lasts
        now += stay
    return _car(rng, t, speed, turn, hills=0.05, shaken=0.3)


def motorway_car(rng: np.random.Generator, t: FloatArray) -> Motion:
    """25 to 35 m/s, bends of 10 to 40 s at 1 to 3 m/s2."""
    speed = 30 * eased((t - 5) / 15) + 4 * drift(rng, t, 30.0) * eased((t - 20) / 10)
    turn = bends(rng, t, 20.0, (10, 40), (15, 60), (1, 3), 30.0)
    return _car(rng, t, np.clip(speed, 0, None), turn, hills=0.03, shaken=0.3)


def truck(rng: np.random.Generator, t: FloatArray) -> Motion:
    """20 m/s, slow bends, a cab that shakes by 2 m/s2."""
    speed = 20 * eased((t - 10) / 40) + 3 * drift(rng, t, 40.0) * eased((t - 50) / 10)
    turn = bends(rng, t, 40.0, (5, 30), (10, 60), (0.5, 2), 20.0)
    return _car(rng, t, np.clip(speed, 0, None), turn, hills=0.04, shaken=2.0)


def aeroplane(rng: np.random.Generator, t: FloatArray) -> Motion:
    """50 m/s, coordinated turns of 15 to 90 s, banks of 10 to 35 deg, climbs."""
    speed = 50 + 5 * drift(rng, t, 40.0)
    turn = bends(rng, t, 20.0, (15, 90), (10, 60), (2, 7), 50.0, ease=4.0)
    return _aircraft(rng, t, speed, turn, attack=0.06)


def small_drone(rng: np.random.Generator, t: FloatArray) -> Motion:
    """18 m/s, now here now there: banks to 45 deg, hardly ever level."""
    speed = 18 + 2 * drift(rng, t, 10.0)
    turn = bends(rng, t, 5.0, (3, 25), (1, 10), (2, 9), 18.0, ease=1.5)
    return _aircraft(rng, t, speed, turn, attack=0.08)


def ship(rng: np.random.Generator, t: FloatArray) -> Motion:
    """8 m/s in a swell: roll 6 deg at 9 s, pitch 2 deg at 7 s, heave, slow turns."""
    speed = 8 + 0.5 * swell(rng, t, 9.0)
    turn = bends(rng, t, 60.0, (40, 120), (60, 200), (0.1, 0.3), 8.0, ease=10.0) + 0.01 * swell(rng, t, 11.0)
    roll, pitch = 0.1 * swell(rng, t, 9.0), 0.035 * swell(rng, t, 7.0)
    heading = integral(turn, rng.uniform(-3, 3))
    return Motion(speed, heading, 0.1 * swell(rng, t, 8.0), pitch, roll, 0.05 * rng.standard_normal((len(t), 3)))


VEHICLES: dict[str, Callable[[np.random.Generator, FloatArray], Motion]] = {
    each.__name__: each for each in (town_car, motorway_car, truck, aeroplane, small_drone, ship)
}


def vehicle_log(kind: str, seed: int, grade: Grade, seconds: float = 400.0) -> AttitudeLog:
    """Return a log of one of `VEHICLES` with truth."""
    rng = np.random.default_rng([seed, list(VEHICLES).index(kind)])
    t: FloatArray = np.arange(0, seconds + PERIOD_S / 2, PERIOD_S)
    motion = VEHICLES[kind](rng, t)
    along = np.stack([np.cos(motion.climb) * np.cos(motion.heading), np.cos(motion.climb) * np.sin(motion.heading),
                      -np.sin(motion.climb)], axis=1)  # fmt: skip
    velocity = motion.speed[:, None] * along
    angles = (motion.heading, motion.pitch, motion.roll)
    C_nb, middle = _body(*angles), _body(*(0.5 * (x[1:] + x[:-1]) for x in angles))
    step = np.swapaxes(C_nb[:-1], 1, 2) @ C_nb[1:]  # small: its antisymmetric part is the angle turned
    rate = np.stack([step[:, i, j] - step[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1) / (2 * PERIOD_S)
    force = np.einsum("nji,nj->ni", middle, np.diff(velocity, axis=0) / PERIOD_S - [0.0, 0.0, G])
    n = len(rate)
    white = rng.standard_normal((3, n, 3)) / np.sqrt(PERIOD_S)
    bias = grade.gyro_bias * rng.standard_normal(3) + grade.gyro_walk * PERIOD_S * np.cumsum(white[1], axis=0)
    rate = rate * (1 + grade.gyro_scale * rng.standard_normal(3)) + bias + grade.gyro_noise * white[0]
    force = force + motion.shaken[1:] + grade.force_bias * rng.standard_normal(3) + grade.force_noise * white[2]
    roll, pitch = roll_pitch_of(C_nb[1:, 2])
    return AttitudeLog(t[1:], rate, force, roll=roll, pitch=pitch, scored=np.ones(n, bool))


def _car(
    rng: np.random.Generator, t: FloatArray, speed: FloatArray, turn: FloatArray, hills: float, shaken: float
) -> Motion:
    """A body that leans out of a bend and dips when it brakes by 0.4 deg per m/s2, on a road up and down."""
    moves, way = np.clip(speed / 5, 0, 1), integral(speed, 0.0)
    climb = hills * np.interp(way, *_road(rng, way[-1], 60.0))
    tilt = 0.4 * np.pi / 180
    along = np.gradient(speed, PERIOD_S)
    camber = 0.5 * hills * np.interp(way, *_road(rng, way[-1], 60.0))
    shake = shaken * moves[:, None] * rng.standard_normal((len(t), 3))
    return Motion(
        speed, integral(turn, rng.uniform(-3, 3)), climb, climb + tilt * along, camber - tilt * speed * turn, shake
    )


def _aircraft(
    rng: np.random.Generator, t: FloatArray, speed: FloatArray, turn: FloatArray, attack: float
) -> Motion:
    bank = np.arctan(speed * turn / G)
    climb = 0.06 * drift(rng, t, 25.0)
    gust = 0.01 * drift(rng, t, 1.0)
    shake = 0.3 * rng.standard_normal((len(t), 3))
    return Motion(
        speed, integral(turn, rng.uniform(-3, 3)), climb, climb + attack / np.cos(bank) + gust, bank + gust, shake
    )


def _body(heading: FloatArray, pitch: FloatArray, roll: FloatArray) -> FloatArray:
    zero = np.zeros_like(heading)
    turns = [np.stack(each, axis=1) for each in ((zero, zero, heading), (zero, pitch, zero), (roll, zero, zero))]
    found: FloatArray = rotation(turns[0]) @ rotation(turns[1]) @ rotation(turns[2])
    return found


def _road(rng: np.random.Generator, length: float, wave: float) -> tuple[FloatArray, FloatArray]:
    """Return points (k,) [m] along a road and a smooth number about 1 at each."""
    at = np.arange(0.0, length + 400.0, 5.0)
    return at, drift(rng, at, wave, period=5.0)


def integral(values: FloatArray, first: float) -> FloatArray:
    """Return the integral over time (n,), from ``first``."""
    return first + np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * PERIOD_S)))


def eased(x: FloatArray) -> FloatArray:
    """Return a step from 0 to 1 without a kink, between x = 0 and 1."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def pulse(t: FloatArray, start: float, lasts: float, ease: float = 1.0) -> FloatArray:
    """Return 1 between ``start`` and ``start + lasts`` [s], eased on both sides."""
    ease = min(ease, 0.5 * lasts)
    return eased((t - start) / ease) * eased((start + lasts - t) / ease)


def bends(
    rng: np.random.Generator, t: FloatArray, first: float, lasts: tuple[float, float], apart: tuple[float, float],
    across: tuple[float, float], speed: float, ease: float = 2.0,
) -> FloatArray:  # fmt: skip
    """Return a turn rate [rad/s]: bends of ``lasts`` [s], ``apart`` [s], of ``across`` [m/s2] at ``speed``."""
    turn, now = np.zeros(len(t)), first
    while now < t[-1]:
        long = rng.uniform(*lasts)
        turn += rng.choice([-1, 1]) * rng.uniform(*across) / speed * pulse(t, now, long, ease)
        now += long + rng.uniform(*apart)
    return turn


def drift(rng: np.random.Generator, t: FloatArray, correlated: float, period: float = PERIOD_S) -> FloatArray:
    """Return smooth noise (n,) of mean square 1, correlated over ``correlated`` (of ``period``'s unit)."""
    every = max(round(correlated / period), 1)
    coarse = rng.standard_normal(len(t) // every + 4)
    at = np.arange(len(t)) / every
    i = at.astype(int)
    x = at - i
    weight = np.stack([(1 - x) ** 3, 3 * x**3 - 6 * x**2 + 4, -3 * x**3 + 3 * x**2 + 3 * x + 1, x**3]) / 6
    found: FloatArray = sum(weight[k] * coarse[i + k] for k in range(4)) / 0.6
    return found


def swell(rng: np.random.Generator, t: FloatArray, period: float) -> FloatArray:
    """Return waves (n,) of mean square about 1 around ``period`` [s]."""
    f = rng.uniform(0.8, 1.2, 6) / period
    phase = rng.uniform(0, 2 * np.pi, 6)
    found: FloatArray = np.sin(2 * np.pi * np.outer(t, f) + phase).sum(axis=1) / np.sqrt(3.0)
    return found
