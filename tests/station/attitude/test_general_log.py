"""Logs as phones and loggers write them, of a body whose motion is known exactly."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.attitude.general_log import read_any_log
from station.cli import run
from station.errors import DataRefused
from station.files.logs.log_columns import ColumnOptions
from tests.procedures.attitude.test_axes_check import G, rocking
from tests.refusals import refused

PHONE = np.diag([1.0, -1.0, -1.0])  # x forward, z up
PHYPHOX = "Gyroscope {} (rad/s)", "Acceleration {} (m/s^2)"
PLAIN = "g{}", "a{}"
SENSOR_LOGGER = "gyroscope_{}", "accelerometer_{}"


def phone_log(
    path: Path, names: tuple[str, str] = PLAIN, time: str = "time", *, tick: float = 1.0, rate: float = 1.0,
    force: float = 1.0, start: float = 0.0, gravity: bool = True, still: bool = False,
) -> FloatArray:  # fmt: skip
    """Write a body that rocks, z up; ``tick``, ``rate``, ``force`` in the log's units; return its roll."""
    log = rocking(0.0 if still else 15.0, noise=0.02)
    f = log.f_b if gravity else 0.5 * np.random.default_rng(5).standard_normal(log.f_b.shape)
    table = np.column_stack([(log.t + start) / tick, log.omega_b @ PHONE * rate, f @ PHONE * force])
    header = [time, *(names[0].format(a) for a in "xyz"), *(names[1].format(a) for a in "xyz")]
    np.savetxt(path, table, "%.9f", ",", header=",".join(header), comments="")
    return np.radians(15.0) * np.sin(0.4 * np.pi * log.t)


@pytest.mark.parametrize(
    ("names", "time", "units"),
    [
        (PLAIN, "time", {}), (PHYPHOX, "Time (s)", {}), (SENSOR_LOGGER, "seconds_elapsed", {}),
        (("gyro_{}_dps", "acc_{}_g"), "timestamp_ms", {"tick": 1e-3, "rate": 180 / np.pi, "force": 1 / G}),
        (PLAIN, "time", {"rate": 180 / np.pi, "force": 1 / G}),
        (("gyro_{}", "acc_{}_mg"), "t_us", {"tick": 1e-6, "rate": 180 / np.pi, "force": 1e3 / G}),
    ],
)  # fmt: skip
def test_a_phones_log_becomes_roll_at_its_own_times(
    tmp_path: Path, names: tuple[str, str], time: str, units: dict[str, float]
) -> None:
    path, out = tmp_path / "phone.csv", tmp_path / "out.csv"
    roll = phone_log(path, names, time, start=20.0, **units)
    assert run(["attitude", str(path), "--out", str(out)]) == 0
    track = np.genfromtxt(out, delimiter=",", names=True)
    assert track["t_s"] == pytest.approx(20.0 + 0.02 * np.arange(3000), abs=1e-6)
    assert np.degrees(np.abs(track["roll_rad"] - roll)[500:].max()) < 1.0


def test_a_specified_unit_is_held_against_motion(tmp_path: Path) -> None:
    phone_log(tmp_path / "log.csv", rate=180 / np.pi)
    assert read_any_log(tmp_path / "log.csv", ColumnOptions(unit_gyro="deg/s")).log is not None
    with refused(DataRefused, ErrorCode.UNIT, "--unit-gyro deg/s"):
        read_any_log(tmp_path / "log.csv", ColumnOptions(unit_gyro="rad/s"))
    phone_log(tmp_path / "log.csv")
    for stated in ("deg/s", "mdeg/s", "deg/h"):
        with refused(DataRefused, None, "--unit-gyro rad/s"):
            read_any_log(tmp_path / "log.csv", ColumnOptions(unit_gyro=stated))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_scale_that_no_lever_arm_makes_is_refused_with_both_causes(factor: float, tmp_path: Path) -> None:
    phone_log(tmp_path / "log.csv", rate=65.5 * 180 / np.pi)
    wrong = ColumnOptions(unit_gyro=f"{65.5 * factor:g}/(deg/s)", unit_accel="m/s2")
    with refused(DataRefused, ErrorCode.UNIT, "--unit-gyro '65.5/(deg/s)'", "--rate"):
        read_any_log(tmp_path / "log.csv", wrong)
    phone_log(tmp_path / "log.csv", rate=180 / np.pi)
    stated = ColumnOptions(unit_gyro="deg/s", unit_accel="m/s2", rate_hz=50.0 * factor)
    with refused(DataRefused, ErrorCode.UNIT, "--unit-gyro", "--rate 50"):
        read_any_log(tmp_path / "log.csv", stated)
    assert read_any_log(tmp_path / "log.csv", replace(stated, rate_hz=50.0)).log is not None


def test_rates_of_a_unit_that_nothing_determines_are_asked_for(tmp_path: Path) -> None:
    phone_log(tmp_path / "log.csv", still=True)
    with refused(DataRefused, ErrorCode.UNIT, "--unit-gyro"):
        read_any_log(tmp_path / "log.csv", None)
    assert read_any_log(tmp_path / "log.csv", ColumnOptions(unit_gyro="rad/s")).log.nominal == pytest.approx(0.02)


def test_linear_acceleration_is_refused(tmp_path: Path) -> None:
    phone_log(tmp_path / "log.csv", PHYPHOX, "Time (s)", gravity=False)
    with refused(DataRefused, ErrorCode.GRAVITY):
        read_any_log(tmp_path / "log.csv", None)


def test_accelerometers_that_read_gravity_are_asked_for(tmp_path: Path) -> None:
    """CoreMotion's raw accelerometer reads -1 g face up; no gyro can tell it from a phone that lies face down."""
    roll = phone_log(tmp_path / "ios.csv", force=-1.0)
    with refused(DataRefused, ErrorCode.AXES):
        read_any_log(tmp_path / "ios.csv", None)
    gravity = read_any_log(tmp_path / "ios.csv", None, convention="gravity").log
    assert np.degrees(np.arctan2(-gravity.f_b[:, 1], -gravity.f_b[:, 2]) - roll).std() < 0.5
    force = read_any_log(tmp_path / "ios.csv", None, convention="force").log
    assert force.f_b == pytest.approx(-gravity.f_b)
    axes = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert read_any_log(tmp_path / "ios.csv", None, axes).log.f_b[:, 2].mean() < -9


def test_axes_turn_both_sensors(tmp_path: Path) -> None:
    phone_log(tmp_path / "log.csv", PHYPHOX, "Time (s)")
    plain = read_any_log(tmp_path / "log.csv", None).log
    turned = read_any_log(tmp_path / "log.csv", None, np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])).log
    assert turned.omega_b[:, 0] == pytest.approx(-plain.omega_b[:, 1])
    assert turned.f_b[:, 1] == pytest.approx(plain.f_b[:, 0])


def test_missing_axes_are_refused(tmp_path: Path) -> None:
    phone_log(tmp_path / "log.csv")
    with refused(DataRefused, ErrorCode.COLUMNS):
        read_any_log(tmp_path / "log.csv", ColumnOptions(gyro=("gx", "gy", "-")))
