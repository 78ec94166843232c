"""Logs of units that grow warmer or colder, as people have them: each gets a sensible word in one line.

Everything here is made by numpy alone, other sensors and other profiles of temperature than the benchmarks'.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station import cli

HOUR = np.arange(0.0, 5400.0, 1.0)  # s
DEG_H = 1 / 3600  # deg/s


def log(folder: Path, name: str, **columns: FloatArray) -> Path:
    """Write columns as a table of text and return its file."""
    file = folder / name
    np.savetxt(file, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    return file


def reported(folder: Path, *options: object) -> Mapping[str, Any]:
    """Return what is said of logs in one line."""
    out = folder / "out.json"
    assert cli.run(["diagnose", *map(str, options), "--json", str(out)]) == 0
    found: Mapping[str, Any] = json.loads(out.read_text())
    return found


def sure(found: Mapping[str, Any]) -> list[str]:
    return [each["effect"] for each in found["findings"] if each["confidence"] in {"established", "likely"}]


def named(found: Mapping[str, Any]) -> set[str]:
    return {name for each in found["findings"] for name in (each["effect"], *each["aliases"])}


def white(seed: int, size: float, n: int = len(HOUR)) -> FloatArray:
    return size * np.random.default_rng(seed).standard_normal(n)


def test_a_slow_cold_start_is_temperature_or_time_and_not_one_of_them_for_sure(tmp_path: Path) -> None:
    warm = -20 + 35 * -np.expm1(-HOUR / 2500)
    gz = 0.02 + 6 * DEG_H * (warm - 25) + white(1, 2e-3)
    found = reported(tmp_path, log(tmp_path, "cold.csv", t_s=HOUR, gz=gz, temp=warm), "--unit-gyro", "deg/s")
    assert {"gyroscope.bias_temperature", "gyroscope.temperature_lag"} & named(found)
    assert not {"gyroscope.bias_drift", "gyroscope.jump"} & set(sure(found))


def test_logs_at_several_temperatures_go_together(tmp_path: Path) -> None:
    files = []
    for number, at in enumerate((-10.0, 20.0, 50.0)):
        warm = at + 3 * np.sin(2 * np.pi * HOUR / 1800 + number)
        ay = 0.1 * number + 6e-4 * (warm - 25) + white(10 + number, 3e-3)  # each stands as it came to stand
        files.append(log(tmp_path, f"at_{at:.0f}.csv", t_s=HOUR, ay=ay, temp=warm))
    found = reported(tmp_path, *files, "--unit-accel", "m/s2")
    assert found["findings"][0]["effect"] == "accelerometer.bias_temperature"
    (value,) = (c for k, c in found["findings"][0]["coefficients"].items() if k in {"y", "y.1"})
    assert abs(value["value"] * 9.80665 - 6e-4) < 4 * value["std"] * 9.80665
    assert set(sure(found)) <= {"accelerometer.bias_temperature"}


def test_a_slope_between_two_temperatures_with_a_tilt_between_them_is_not_claimed(tmp_path: Path) -> None:
    """A tilt of 0.5 deg is 8.6e-2 m/s2, a coefficient of 4.3e-3 m/s2/K to whoever draws a line through both."""
    files = [
        log(tmp_path, f"{at}.csv", t_s=HOUR, ax=tilt + white(at, 3e-3), temp=at + 0.05 * np.sin(HOUR / 300))
        for at, tilt in ((20, 0.0), (40, 9.80665 * np.sin(np.radians(0.5))))
    ]
    assert reported(tmp_path, *files, "--unit-accel", "m/s2")["findings"] == []


def test_a_gyroscope_in_an_oven_with_plateaus_has_a_curve_and_a_lag(tmp_path: Path) -> None:
    t = np.arange(0.0, 4 * 3600.0, 1.0)
    warm = np.interp(t, [0, 1800, 3600, 5400, 7200, 9000, 10800, 14400], [20, 20, 55, 55, 0, 0, 40, 40])
    sensor = warm.copy()
    for i in range(1, len(t)):
        sensor[i] = sensor[i - 1] + (warm[i] - sensor[i - 1]) / 500
    gy = DEG_H * (2.0 * (sensor - 25) + 0.03 * (sensor - 25) ** 2) + white(5, 3e-3, len(t))
    found = reported(tmp_path, log(tmp_path, "oven.csv", t_s=t, gy=gy, temp=warm), "--unit-gyro", "deg/s")
    lag = next(each for each in found["findings"] if each["effect"] == "gyroscope.temperature_lag")
    tau = lag["coefficients"]["tau_s"]
    assert abs(tau["value"] - 500) < 4 * tau["std"] + 1
    (error,) = (each for each in found["error"] if each["quantity"] == "gyroscope soaks")
    assert error["held_out_after"] < 0.1 * error["held_out_before"]


def test_temperature_that_does_nothing_is_not_named(tmp_path: Path) -> None:
    warm = np.round(22 + 8 * np.sin(2 * np.pi * HOUR / 5000), 1)
    columns = {f"a{axis}": white(210 + i, 2e-3) for i, axis in enumerate("xyz")}
    found = reported(tmp_path, log(tmp_path, "quiet.csv", t_s=HOUR, **columns, temp=warm), "--unit-accel", "m/s2")
    assert (found["verdict"], found["findings"]) == ("consistent", [])
