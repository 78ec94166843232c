"""A gyroscope tells that a recording turned; drifts, jumps, noise and wrong rows do not."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.sample_records import RateSeries
from procedures.rests_and_moves.turning import Turning, turning

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
