"""A ROS 2 bag of a few rows: what of a triad tells whether it is there, and which times it can have."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.calibrated_sample_writers import Ros2Samples, SampleColumns
from tests.refusals import refused

pytest.importorskip("rosbags")

NAN = float("nan")
NAMES = ("t_s", "ax", "ay", "az", "gx", "gy", "gz")
ROW = [1.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


def written(path: Path, rows: list[list[float]], names: tuple[str, ...] = NAMES) -> Path:
    writer = Ros2Samples(path, SampleColumns(names, len(rows), "housing", is_si=True))
    writer.write(list(np.array(rows).T))
    writer.finish()
    return path


def read(path: Path) -> list[tuple[str, int, Any]]:
    from rosbags.highlevel import AnyReader

    with AnyReader([path]) as reader:
        return [(each.topic, at, reader.deserialize(data, each.msgtype)) for each, at, data in reader.messages()]


@pytest.mark.parametrize(
    ("column", "force", "rate"),
    [(0, 0.0, 0.0), (1, -1.0, 0.0), (2, 0.0, 0.0), (4, 0.0, -1.0), (6, 0.0, 0.0)],
)
def test_a_triad_without_its_x_is_absent(column: int, force: float, rate: float, tmp_path: Path) -> None:
    row = [*ROW]
    if column:
        row[column] = NAN
    ((topic, at, reported),) = read(written(tmp_path / "bag", [row]))
    assert (topic, at) == ("/imu/data", 1_500_000_000)
    assert reported.linear_acceleration_covariance.tolist() == [force] + [0.0] * 8
    assert reported.angular_velocity_covariance.tolist() == [rate] + [0.0] * 8
    assert reported.orientation_covariance.tolist() == [-1.0] + [0.0] * 8
    found = [
        getattr(each, axis) for each in (reported.linear_acceleration, reported.angular_velocity) for axis in "xyz"
    ]
    assert found == pytest.approx(row[1:], nan_ok=True)


@pytest.mark.parametrize(
    ("t", "seconds", "nanoseconds"),
    [
        (0.0, 0, 0),
        (0.999999999, 0, 999_999_999),
        (1.0, 1, 0),
        (7.0000000016, 7, 2),
        (-0.4e-9, 0, 0),
    ],
)
def test_a_time_is_in_whole_nanoseconds(t: float, seconds: int, nanoseconds: int, tmp_path: Path) -> None:
    ((_, at, reported),) = read(written(tmp_path / "bag", [[t, *ROW[1:]]]))
    assert at == seconds * 10**9 + nanoseconds
    assert (reported.header.stamp.sec, reported.header.stamp.nanosec) == (seconds, nanoseconds)


def test_a_time_of_a_nanosecond_before_zero_is_refused(tmp_path: Path) -> None:
    writer = Ros2Samples(tmp_path / "bag", SampleColumns(NAMES, 1, "housing", is_si=True))
    with refused(DataRefused, None, "-6e-10"):
        writer.write(list(np.array([[-0.6e-9, *ROW[1:]]]).T))
    writer.abandon()


def test_other_units_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    with refused(DataRefused, None, "m/s2,rad/s", "--units"):
        Ros2Samples(tmp_path / "bag", SampleColumns(NAMES, 1, "housing", is_si=False))
    assert not (tmp_path / "bag").exists()
