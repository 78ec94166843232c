"""Stillness by the unit's own noise, faces by raw counts."""

import numpy as np
import pytest

from drivers.simulated.bench import SimulatedBench
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.frames import FACES, face_normal, rotation
from procedures.records import CountBlock, CountSeries
from procedures.steps import Dwell
from station.benches.face import remark, seen_face
from station.benches.stillness import Block, Stillness, block_of


def block(gyro: FloatArray, accel: FloatArray) -> Block:
    n = len(gyro)
    t = 0.02 * np.arange(1, n + 1)
    counts = CountBlock(
        np.arange(n), t, gyro.astype(np.int64), accel.astype(np.int64), t, np.arange(n), np.ones(n, dtype=bool)
    )
    return block_of(counts, 0, 0.02, is_broken=False, is_anew=False)


def still_blocks(seed: int, seconds: int = 200) -> list[Block]:
    series = SimulatedBench(Truth.example(seed), seed).perform(Dwell(1 + seed % 12, float(seconds)))
    assert isinstance(series, CountSeries)
    assert series.gyro is not None
    assert series.accel is not None
    return [block(series.gyro[i : i + 50], series.accel[i : i + 50]) for i in range(0, 50 * seconds, 50)]


@pytest.mark.parametrize("seed", range(5))
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


@pytest.mark.parametrize("face", FACES)
def test_each_face_is_recognised_and_no_other_passes(face: str) -> None:
    accel = 1000 * face_normal(face) + [20, -15, 8]
    assert seen_face(accel, np.eye(3))[0] == face
    assert remark(accel, np.eye(3), face) == ""
    assert all("expected" in remark(accel, np.eye(3), other) for other in FACES if other != face)


def test_a_tilt_is_said_in_degrees() -> None:
    accel = rotation(np.array([0.0, np.radians(20.0), 0.0])) @ np.array([1000.0, 0.0, 0.0])
    assert remark(accel, np.eye(3), "x_up") == "tilted by 20 deg, limit 5 deg"


def test_a_turned_mounting_is_taken_into_account() -> None:
    C_ib = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # IMU x along cube y, y along -x
    assert seen_face(C_ib @ (1000 * face_normal("x_up")), C_ib)[0] == "x_up"
