"""Whether a recording rests in two attitudes at least, and about how far it turned: series written down."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.sample_records import RateSeries
from procedures.rests_and_moves.moving import moves_and_rests, true_angle, turned_deg, whole_turns

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
def test_whole_turns_beside_a_part_of_one(gyro: float, beyond: float, angle: float | None) -> None:
    found = true_angle(gyro, beyond, 0.03, 2.0)
    assert (None if found is None else round(found, 6)) == angle
