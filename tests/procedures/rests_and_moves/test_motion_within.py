"""Rests that move are told from rests by what is slower than the noise between neighbouring samples."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from procedures.arrays import FloatArray
from procedures.campaign.campaign import RestRecord
from procedures.counts.sample_records import RateSeries
from procedures.rests_and_moves.rest_detection import motion_within

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


@pytest.mark.parametrize("noise", [1e-5, 1e-3, 5e-3])
@pytest.mark.parametrize("name", STILL)
def test_a_unit_at_rest_does_not_move(name: str, noise: float) -> None:
    assert motion_within(rests(STILL[name], noise), K) is None


@pytest.mark.parametrize("noise", [1e-5, 1e-3, 5e-3])
@pytest.mark.parametrize("name", MOVING)
def test_a_unit_that_moves_all_the_time_does(name: str, noise: float) -> None:
    found = motion_within(rests(MOVING[name], noise), K)
    assert found is not None
    assert found > 3e-3
