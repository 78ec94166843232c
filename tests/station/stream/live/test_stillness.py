"""Stillness by the unit's own noise; moments of samples by the reads that lagged least."""

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell
from procedures.counts.sample_records import CountBlock, CountSeries
from station.stream.live.stillness import Block, Stillness, block_of
from station.stream.recorder.sample_times import SampleMoments


def block(gyro: FloatArray, accel: FloatArray) -> Block:
    n = len(gyro)
    t = 0.02 * np.arange(1, n + 1)
    counts = CountBlock(
        np.arange(n), t, gyro.astype(np.int64), accel.astype(np.int64), t, np.arange(n), np.ones(n, dtype=bool)
    )
    return block_of(counts, 0, 0.02, is_broken=False, is_restarted=False)


def still_blocks(seed: int, seconds: int = 200) -> list[Block]:
    series = SimulatedBench(Truth.example(seed), seed).perform(Dwell(1 + seed % 12, float(seconds)))
    assert isinstance(series, CountSeries)
    assert series.gyro is not None
    assert series.accel is not None
    return [block(series.gyro[i : i + 50], series.accel[i : i + 50]) for i in range(0, 50 * seconds, 50)]


@pytest.mark.parametrize("seed", range(2))
def test_a_cube_at_rest_is_still_once_the_noise_is_known(seed: int) -> None:
    judge = Stillness()
    judged = []
    for each in still_blocks(seed):
        judge.learn(each)
        judged.append(judge.is_still(each))
    assert not any(judged[:4])
    assert all(judged[4:])


@pytest.mark.parametrize("axis", range(3))
def test_a_trembling_of_5_times_the_noise_is_not_still(axis: int) -> None:
    judge, blocks = Stillness(), still_blocks(1, 20)
    for each in blocks:
        judge.learn(each)
    sigma = np.sqrt(judge.noise[axis])
    rng = np.random.default_rng(axis)
    gyro = np.zeros((50, 3))
    gyro[::5, axis] = rng.normal(0, 8 * sigma, 10)
    assert not judge.is_still(block(gyro, np.zeros((50, 3))))


def test_samples_of_one_read_were_taken_one_after_another() -> None:
    moments = SampleMoments()
    reads = [(0.1, 1.0), (0.5, 1.0), (1.0, 1.0), (1.1, 2.003), (2.0, 2.003)]  # device time, read at [s]
    found = [moments.of(t, round(read * 1e9)) / 1e9 for t, read in reads]
    assert found[2:] == [1.0, 1.1, 2.0]
    moments.reset()
    assert moments.of(0.0, 5 * 10**9) == 5 * 10**9


@pytest.mark.parametrize(("pace", "most_off"), [(1.0, 0.001), (0.9995, 0.04), (0.1, 0.2), (20.0, 0.2)])
def test_a_device_that_goes_slower_than_it_says_is_followed(pace: float, most_off: float) -> None:
    """The device's ``pace`` in its own seconds per second; each read is late by up to 0.3 s."""
    moments, rng = SampleMoments(), np.random.default_rng(3)
    device = 0.1 * np.arange(1, 2000)
    true = 5.0 + device / pace
    late = rng.exponential(0.03, len(device)).clip(0.0, 0.3)
    read = np.round((true + late) * 1e9).astype(np.int64)
    found = np.array([moments.of(t, at) / 1e9 for t, at in zip(device.tolist(), read.tolist(), strict=True)])
    assert (found <= read / 1e9).all()
    assert np.abs(found - true)[60:].max() < most_off
