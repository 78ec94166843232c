from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.simulated.cube_motion import flip, rest
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.sensor_model import CountingTriads
from drivers.simulated.truth import Truth
from procedures.counts.sample_records import CountBlock

TRUTH = replace(
    Truth.example(1),
    accel_instability_g=1e-6,
    temperature_rise_k=5.0,
    effects={"accelerometer.relaxation": {"x": 1e-3}, "gyroscope.scale_temperature": {"x": 50.0}},
)


def moved(seed: int | None = 3) -> SimulatedImu:
    imu = SimulatedImu(TRUTH, seed)
    imu.rest(1.0)
    imu.place(3, 6.0)
    imu.turn("x", "-", 1)
    return imu


def joined(blocks: list[CountBlock], name: str) -> np.ndarray:
    return np.concatenate([getattr(block, name) for block in blocks])


WHOLE = moved().read(1500)


@settings(max_examples=30)
@given(cuts=st.lists(st.integers(0, 400), max_size=12))
def test_counts_do_not_depend_on_how_they_are_read(cuts: list[int]) -> None:
    imu, sizes = moved(), [cut for i, cut in enumerate(cuts) if sum(cuts[: i + 1]) <= 1500]
    blocks = [imu.read(size) for size in [*sizes, 1500 - sum(sizes)]]
    for name in ("counter", "device_time", "gyro", "accel", "temperature"):
        assert np.array_equal(joined(blocks, name), getattr(WHOLE, name)), name


def test_no_fraction_of_a_count_is_ever_lost() -> None:
    bench = SimulatedImu(TRUTH, None)
    C_bn = bench.world.attitude(1)
    sensor = CountingTriads(TRUTH, bench.world, (), None)
    total, expected = np.zeros(3), np.zeros(3)
    for first in range(0, 2000, 7):
        _, accel = sensor.counts(rest(C_bn, None, 1), first, first, first + 7)
        total += accel.sum(0)
        expected += 7 * 0.02 * TRUTH.accel_k * sensor.output(rest(C_bn, None, 1), first, first, first + 7)[0, :3]
        assert np.all((total <= expected + 1e-6) & (total > expected - 1 - 1e-6)), (
            "the count is the integral's floor"
        )


def test_a_rate_output_is_what_the_counts_of_the_same_unit_add_up_to() -> None:
    world, samples = SimulatedImu(TRUTH, None).world, 5000
    standing = rest(world.attitude(5), None, 1)
    counting, decisive = (CountingTriads(TRUTH, world, (), None) for _ in range(2))
    counts, rates = counting.counts(standing, 0, 0, samples), decisive.rates(standing, 0, 0, samples)
    for count, rate in zip(counts, rates, strict=True):
        assert rate.shape == (samples, 3)
        assert rate.mean(axis=0) * samples * counting.period == pytest.approx(count.sum(axis=0), abs=1.0)


def test_commands_queue_and_the_end_is_predicted() -> None:
    imu = moved()
    done = imu.done
    assert imu.is_moving
    imu.read(round(done / 0.02))
    assert not imu.is_moving
    assert imu.done == imu.time == pytest.approx(done)
    accel = imu.read(500).accel.sum(0) / 10 / TRUTH.accel_k
    assert abs(accel[0] + 1) < 0.01, "position 3 has x down"


def test_a_move_is_seen_in_the_counts_and_the_rest_after_it_is_quiet() -> None:
    imu = SimulatedImu(TRUTH, 1)
    still = np.abs(imu.read(250).gyro).max()
    imu.place(6, 10.0)
    moving = np.abs(imu.read(500).gyro).max()
    imu.read(250)
    assert moving > 1000 * max(still, 1)
    assert np.abs(imu.read(250).gyro).max() <= still + 2


def test_a_settling_dies_away_within_seconds() -> None:
    imu = SimulatedImu(replace(TRUTH, settle_rad=1e-3), 1)
    imu.place(2, 2.0)
    imu.read(100)
    spread = [np.std(imu.read(25).gyro, axis=0).max() for _ in range(8)]
    assert spread[0] > 20 * spread[-1]


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, np.pi - 1e-9, np.pi])
def test_a_flip_ends_exactly_where_it_should(angle: float) -> None:
    imu = SimulatedImu(TRUTH, None)
    begin = imu.world.attitude(1)
    for end in (imu.world.attitude(4, angle), imu.world.attitude(1, angle), imu.world.attitude(2)):
        segment = flip(begin, end, 200, 0.02, np.random.default_rng(1))
        assert np.max(np.abs(segment.end_C_bn() - end)) < 1e-7


@pytest.mark.parametrize(
    ("refused", "named"),
    [
        (lambda imu: imu.place(25), "1 to 24"),
        (lambda imu: imu.rest(-1.0), "0 to 1e6"),
        (lambda imu: imu.turn("y", "+", 1), "not vertical"),
        (lambda imu: imu.turn("w", "+", 1), "expected one of"),
        (lambda imu: imu.turn("x", "left", 1), "expected one of"),
        (lambda imu: imu.turn("x", "+", 0), "1 to 100"),
    ],
)
def test_hands_refuse_what_cannot_be_done_and_do_nothing(refused, named: str) -> None:
    imu = SimulatedImu(TRUTH, 1)
    with pytest.raises(ValueError, match=named):
        refused(imu)
    assert not imu.is_moving
