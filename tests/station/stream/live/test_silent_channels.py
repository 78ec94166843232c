"""A dead channel is named live; one that counts slowly, as a level accelerometer does, is not."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.wire import ALL_CHANNELS, FORMATS
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.stream.live.stream_trouble import SilentChannels, refuse_partial
from tests.refusals import refused

TRUTH = Truth.example(5)


def without(triad: str, axes: str) -> Truth:
    """Return the truth of a unit whose channels do not count."""
    k = np.where([axis in axes for axis in "xyz"], 0.0, getattr(TRUTH, f"{triad}_k"))
    return replace(TRUTH, **{f"{triad}_k": k})


def watched(truth: Truth, seconds: float, rates: bool = False) -> str:
    imu, watch = SimulatedImu(truth, 3), SilentChannels()
    for _ in range(round(seconds / 0.5)):
        watch.take(imu.read_rates(25) if rates else imu.read(25))
    return watch.text(0.02, ALL_CHANNELS)


@pytest.mark.parametrize("rates", [False, True], ids=["counts", "rates"])
@pytest.mark.parametrize(
    ("triad", "axes", "name"),
    [("gyro", "yz", "gyroscope"), ("gyro", "xyz", "gyroscope"), ("accel", "xyz", "accelerometer")],
)
def test_dead_channels_are_named_after_ten_seconds(triad: str, axes: str, name: str, rates: bool) -> None:
    reported = watched(without(triad, axes), 12.0, rates)
    assert all(f"{name} {axis} a constant 0" in reported for axis in axes)
    assert reported.count("constant") == len(axes)
    assert "check its wiring" in reported
    assert watched(without(triad, axes), 8.0, rates) == ""


@pytest.mark.parametrize("rates", [False, True], ids=["counts", "rates"])
def test_a_healthy_unit_has_none_though_a_level_accelerometer_does_not_count(rates: bool) -> None:
    assert watched(TRUTH, 100.0, rates) == ""


@pytest.mark.parametrize("is_dead", [False, True], ids=["healthy", "dead"])
def test_only_a_dead_accelerometer_is_named_while_the_cube_is_carried_about(is_dead: bool) -> None:
    imu, watch, reported = (
        SimulatedImu(without("accel", "y") if is_dead else TRUTH, 3),
        SilentChannels(),
        set[str](),
    )
    for position in (1, 3, 5, 7, 9, 11, 2):
        imu.place(position, 5.0)
        for _ in range(80):
            watch.take(imu.read(25))
            reported.add(watch.text(0.02, ALL_CHANNELS).partition(" for ")[0])
    assert reported - {""} == ({"accelerometer y a constant 0"} if is_dead else set())


def test_a_channel_that_stops_is_named_and_one_that_comes_back_is_not_any_more() -> None:
    imu, watch = SimulatedImu(TRUTH, 3), SilentChannels()
    watch.take(imu.read(1000))
    block = imu.read(600)
    gyro = block.gyro.copy()
    gyro[:, 1] = 17
    watch.take(replace(block, gyro=gyro))
    assert "gyroscope y a constant 17 for 12 s" in watch.text(0.02, ALL_CHANNELS)
    watch.take(imu.read(100))
    assert watch.text(0.02, ALL_CHANNELS) == ""


def test_a_one_axis_gyroscope_is_refused_where_attitude_is_asked_for() -> None:
    with refused(DataRefused, ErrorCode.CHANNELS, "gy, gz, ax, ay, az", "station record"):
        refuse_partial("/dev/ttyUSB0", FORMATS["ch70"].imu)
    refuse_partial("/dev/ttyUSB0", FORMATS["counts"].imu)
