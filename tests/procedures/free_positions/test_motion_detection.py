"""Whether and by how much a recording moved and rotated; rests that move."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from procedures.arrays import FloatArray
from procedures.campaign.campaign import RestRecord
from procedures.counts.sample_records import RateSeries
from procedures.free_positions.rest_detection import (
    Turning,
    motion_within,
    moves_and_rests,
    true_angle,
    turned_deg,
    turning,
    whole_turns,
)

PERIOD = 0.01
N = 1500


def series(accel: FloatArray | None, gyro: FloatArray | None = None) -> RateSeries:
    n = len(accel if accel is not None else gyro if gyro is not None else ())
    t = PERIOD * np.arange(1, n + 1)
    return RateSeries(t, gyro, accel, np.full(n, np.nan), PERIOD)


def two_rests(apart: float, noise: float = 1.0, drift: float = 0.0) -> FloatArray:
    """Return rest, a move that shakes, and rest ``apart`` [output]; each drifts by ``drift`` from half to half."""
    rng, shake = np.random.default_rng(2), 300
    signal = noise * rng.normal(size=(2 * N + shake, 3))
    signal[N + shake :, 0] += apart
    signal[:N, 2] += np.linspace(-drift, drift, N)
    signal[N + shake :, 2] += np.linspace(-drift, drift, N)
    signal[N : N + shake] += 300.0 * noise * rng.normal(size=(shake, 3))
    return signal


@pytest.mark.parametrize(("apart", "moved"), [(90.0, False), (110.0, True), (-110.0, True)])
def test_a_move_turns_the_vertical_by_a_tenth_of_a_g(apart: float, moved: bool) -> None:
    assert moves_and_rests(series(two_rests(apart)), outputs_per_g=1000.0) == moved


def test_one_rest_or_no_accelerometer_is_no_sequence() -> None:
    rng = np.random.default_rng(1)
    assert not moves_and_rests(series(rng.normal(size=(N, 3))), 1e-9)
    assert not moves_and_rests(series(None, rng.normal(size=(N, 3))), 1e-9)


@pytest.mark.parametrize(
    ("degrees", "turns"),
    [(361.0, 1), (720.0, 2), (-720.0, 2), (3604.0, 10), (366.76, None), (890.0, None), (180.0, None), (0.0, None)],
)
def test_whole_revolutions_are_those_above_the_rate_at_both_ends(degrees: float, turns: int | None) -> None:
    gyro = np.full((1000, 3), 7.0)
    gyro[200:700, 1] += degrees * 40.0 / (500 * PERIOD)  # 40 outputs at 1 deg/s
    assert turned_deg(series(None, gyro), 1, 40.0) == pytest.approx(degrees)
    assert whole_turns(turned_deg(series(None, gyro), 1, 40.0)) == turns


@pytest.mark.parametrize(
    ("gyro", "beyond", "angle"),
    [
        (367.0, 6.76, 366.76), (-367.0, 6.76, None), (-367.0, -6.76, -366.76), (-353.0, 6.76, -353.24),
        (7.9, 6.76, 6.76), (0.0, 6.76, None), (150 * 361.0, 6.76, None),
    ],
)  # fmt: skip
def test_whole_turns_with_a_part_of_one(gyro: float, beyond: float, angle: float | None) -> None:
    found = true_angle(gyro, beyond, 0.03, 2.0)
    assert (None if found is None else round(found, 6)) == angle


# Rotations seen by a gyroscope


RATE = 50
T = np.arange(600 * RATE) / RATE


def seen(rate: FloatArray, hertz: float = RATE, noise: float = 0.05, unit: float = 1.0) -> Turning | None:
    """Return what is said of a z gyroscope of so many outputs in 1 deg/s that puts out ``rate`` (n,) [deg/s]."""
    gyro = noise * np.random.default_rng(1).standard_normal((len(rate), 3))
    gyro[:, 2] += rate
    t, unknown = np.arange(len(rate)) / hertz, np.full(len(rate), np.nan)
    return turning(RateSeries(t, unit * gyro, None, unknown, 1 / hertz, np.zeros(1, np.int64)), unit)


def pulse(begin: float, end: float, size: float) -> FloatArray:
    return size * ((begin <= T) & (end > T))


TABLE = np.repeat([0, 10, -10, 20, -20, 40, -40, 60, -60, 150, -150, 0.0], 500)


@pytest.mark.parametrize("rate", [
    pulse(100, 124, -30) + pulse(300, 324, 30), 20 * np.sin(T), TABLE, pulse(200, 600, 25),
    np.where((T > 100) & (T < 136), 5 * np.sin(np.pi * (T - 100) / 36), 0) + 3.0,
])  # fmt: skip
@pytest.mark.parametrize("unit", [1.0, 131.0])
def test_turns_are_seen(rate: FloatArray, unit: float) -> None:
    found = seen(rate, unit=unit)
    assert found is not None
    assert found.axis == 2
    assert found.fastest == pytest.approx(np.abs(rate - rate[0]).max(), rel=0.05, abs=0.2)


@pytest.mark.parametrize("rate", [
    0 * T, 6 * T / 600, 3 * np.exp(-T / 20), pulse(300, 600, 3.0), pulse(50, 52, -999.0),
    -999.0 * (np.arange(len(T)) % 40 == 0),
    3e-3 * np.cumsum(np.random.default_rng(2).standard_normal(len(T))), 5.0 + 0 * T,
])  # fmt: skip
def test_what_a_unit_at_rest_does_is_no_turn(rate: FloatArray) -> None:
    assert seen(rate) is None


def test_the_longest_rest_leaves_out_where_a_turn_begins_and_ends() -> None:
    found = seen(pulse(100, 124, -30) + pulse(300, 324, 30))
    assert found is not None
    assert (found.sign, found.rest) == (-1, slice(325 * RATE, 600 * RATE))
    spinning = seen(pulse(5, 600, 25) + 0.1 * np.sin(T))
    assert spinning is not None
    assert spinning.rest is None


# Rests that move are told from rests by what is slower than the noise between neighbouring samples


FS = 100.0
K = np.array([1.0, 0.99, 1.01])
Motion = Callable[[FloatArray, np.random.Generator], FloatArray]


def coloured(rng: np.random.Generator, n: int, tau_s: float, std: float) -> FloatArray:
    a = np.exp(-1 / FS / tau_s)
    return std * np.asarray(lfilter([np.sqrt(1 - a * a)], [1, -a], rng.standard_normal((n, 3)), axis=0))


def rests(motion: Motion, noise: float, seconds: float = 4.0, k: FloatArray = K) -> list[RestRecord]:
    rng, found = np.random.default_rng(1), list[RestRecord]()
    for number in range(14):
        t = np.arange(round(seconds * FS)) / FS
        up = rng.standard_normal(3)
        f = up / np.linalg.norm(up) + motion(t, rng) + noise * rng.standard_normal((len(t), 3))
        series = RateSeries(t, None, k * f, np.full(len(t), np.nan), 1 / FS)
        found.append(RestRecord(f"rest {number}", None, series))
    return found


STILL: dict[str, Motion] = {
    "nothing": lambda t, rng: np.zeros((len(t), 3)),
    "bias instability of 0.1 mg": lambda t, rng: coloured(rng, len(t), 5.0, 1e-4),
    "a table that settles by 0.03 deg": lambda t, rng: np.outer(5e-4 * np.exp(-t / 0.5), [1, 0, 0]),
    "a fan at 23 Hz": lambda t, rng: np.outer(0.02 * np.sin(2 * np.pi * 23 * t), [0, 1, 0]),
    "warming by 1 mg/min": lambda t, rng: np.outer(1e-3 * t / 60, [1, 1, 1]),
    "a low-pass of 10 Hz": lambda t, rng: coloured(rng, len(t), 0.016, 2e-3),
}
MOVING: dict[str, Motion] = {
    "turned at 3 deg/s": lambda t, rng: np.outer(np.radians(3) * t, [1, 0, 0]),
    "held by hand, 0.5 deg": lambda t, rng: coloured(rng, len(t), 0.5, 0.009),
    "carried": lambda t, rng: coloured(rng, len(t), 0.3, 0.1),
    "a boat": lambda t, rng: np.outer(0.05 * np.sin(2 * np.pi * t / 6 + rng.uniform(0, 6)), [1, 1, 0]),
    "a vehicle that brakes": lambda t, rng: np.outer(0.03 * np.minimum(t, 2.0), [1, 0, 0]),
    "a drone that hovers": lambda t, rng: (
        coloured(rng, len(t), 0.4, 0.03) + np.outer(0.1 * np.sin(2 * np.pi * 41 * t), [0, 0, 1])
    ),
    "a swing": lambda t, rng: np.outer(0.02 * np.sin(2 * np.pi * 0.4 * t), [0, 1, 0]),
}


@pytest.mark.parametrize("noise", [1e-5, 5e-3])
@pytest.mark.parametrize("name", STILL)
def test_a_unit_at_rest_does_not_move(name: str, noise: float) -> None:
    assert motion_within(rests(STILL[name], noise), K) is None


@pytest.mark.parametrize("noise", [1e-5, 5e-3])
@pytest.mark.parametrize("name", MOVING)
def test_a_unit_that_moves_all_the_time_does(name: str, noise: float) -> None:
    found = motion_within(rests(MOVING[name], noise), K)
    assert found is not None
    assert found > 3e-3
