"""``station diagnose LOG``: a table from elsewhere in one line, what it shows, and what it does not."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station import cli
from tests.paths import DATA

N, PERIOD = 12_000, 0.25  # 50 minutes
T = PERIOD * np.arange(1, N + 1)
TEMPERATURE = 25 + 8 * np.sin(2 * np.pi * T / T[-1])  # up and down again
BIAS_PER_K = np.array([80.0, -50.0, 120.0])  # ug/K


def accelerometers(seed: int, per_k: FloatArray = BIAS_PER_K) -> FloatArray:
    """Specific force [m/s2]: at rest askew, 50 ug of white noise a sample, a bias by temperature."""
    rng = np.random.default_rng(seed)
    g = np.array([0.1, -0.3, 0.95]) + 1e-6 * per_k * (TEMPERATURE[:, None] - 25)
    return 9.80665 * (g + 5e-5 * rng.standard_normal((N, 3)))


def save(file: Path, columns: dict[str, FloatArray]) -> Path:
    np.savetxt(
        file,
        np.stack(list(columns.values()), axis=1),
        fmt="%.8g",
        delimiter=";",
        header=";".join(columns),
        comments="",
    )
    return file


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    f = accelerometers(1)
    columns = {"time_s": T, "acc_x": f[:, 0], "acc_y": f[:, 1], "acc_z": f[:, 2], "temperature": TEMPERATURE}
    return save(tmp_path_factory.mktemp("log") / "oven.csv", columns)


def diagnosed(tmp_path: Path, *arguments: str) -> dict[str, Any]:
    out = tmp_path / "out.json"
    assert cli.run(["diagnose", *arguments, "--json", str(out)]) == 0
    document: dict[str, Any] = json.loads(out.read_text())
    return document


def test_a_soak_s_temperature_coefficient_is_found_without_a_calibration(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = diagnosed(tmp_path, str(log))
    (finding,) = document["findings"]
    assert finding["effect"] == "accelerometer.bias_temperature"
    assert document["p_value"] > 0.01
    for axis, true in zip("xyz", BIAS_PER_K, strict=True):
        got = finding["coefficients"][axis]
        assert abs(got["value"] - 1e-6 * true) < 4 * got["std"]
    (error,) = document["error"]
    assert error["held_out_after"] < 0.1 * error["held_out_before"]
    assert "solution" not in document
    assert "accelerometer.bias" in document["not_observable"]
    assert "accelerometers in m/s2" in capsys.readouterr().err


def test_noise_and_drift_of_every_channel_are_reported_in_the_unit_specified(log: Path, tmp_path: Path) -> None:
    document = diagnosed(tmp_path, str(log), "--accel", "acc_x,acc_y,acc_z", "--unit-accel", "m/s2")
    channels = document["channels"]
    assert [each["channel"] for each in channels] == [f"accelerometer {axis}" for axis in "xyz"]
    walk = channels[0]["random_walk"]
    assert walk["unit"] == "ug/sqrt(Hz)"
    assert walk["value"] == pytest.approx(50 * PERIOD**0.5, rel=0.03)


def test_what_was_found_in_one_log_is_tested_on_another(log: Path, tmp_path: Path) -> None:
    f = accelerometers(2)
    columns = {"time_s": T, "acc_x": f[:, 0], "acc_y": f[:, 1], "acc_z": f[:, 2], "temperature": TEMPERATURE}
    other, kept = save(tmp_path / "other.csv", columns), tmp_path / "kept"
    diagnosed(tmp_path, str(other), "--campaign", str(kept))
    errors = diagnosed(tmp_path, str(log), "--validate", str(kept), "--validate", str(other))["error"]
    by_folder, by_log = (
        next(row for row in errors if row["method"] == f"validation: {name}") for name in (kept, other)
    )
    assert by_folder["held_out_after"] < 0.1 * by_folder["held_out_before"]
    assert by_log["held_out_after"] == pytest.approx(by_folder["held_out_after"])


def test_pure_noise_is_consistent_and_too_short_a_log_is_exit_5(tmp_path: Path) -> None:
    f = accelerometers(3, np.zeros(3))
    columns = {"t_s": T, "ax": f[:, 0], "ay": f[:, 1], "az": f[:, 2], "temp": TEMPERATURE}
    assert diagnosed(tmp_path, str(save(tmp_path / "quiet.csv", columns)))["verdict"] == "consistent"
    short = {name: values[:40] for name, values in columns.items()}
    assert cli.run(["diagnose", str(save(tmp_path / "short.csv", short))]) == 5


def test_a_single_axis_fog_without_time_or_header_in_one_line(tmp_path: Path) -> None:
    rng, n = np.random.default_rng(2), 36_000  # an hour at 10 Hz
    warm = 20 + 15 * np.sin(2 * np.pi * np.arange(n) / n)
    rate = 3 + 0.4 * (warm - 25) + 6 * rng.standard_normal(n)  # deg/h
    np.savetxt(tmp_path / "fog.txt", np.column_stack((rate, warm)), fmt="%.6f")
    options = ("--rate", "10", "--gyro", "-,-,1", "--unit-gyro", "deg/h", "--temperature", "2")
    document = diagnosed(tmp_path, str(tmp_path / "fog.txt"), *options, "--html", str(tmp_path / "page.html"))
    (finding,) = document["findings"]
    assert (finding["effect"], finding["unit"]) == ("gyroscope.bias_temperature", "deg/h/K")
    got = finding["coefficients"]["z"]
    assert abs(got["value"] - 0.4) < 4 * got["std"]
    (channel,) = document["channels"]
    assert channel["random_walk"]["value"] == pytest.approx(6 * 0.1**0.5 / 60, rel=0.03)  # deg/sqrt(h)
    assert "gyroscope.bias_temperature" in (tmp_path / "page.html").read_text()


def test_a_mems_gyroscope_s_temperature_coefficient_is_named_and_no_jump(tmp_path: Path) -> None:
    """0.27 deg/sqrt(h) and 10.8 deg/h/K: ADIS16488A, data sheet, of 0.26 deg/sqrt(h) and 0.0025 (deg/s)/degC."""
    rng, n = np.random.default_rng(3), 14_400  # 2 Hz
    t = np.arange(1, n + 1) / 2
    warm = 25 + 4 * np.tanh((t - t[-1] / 2) / 1800)  # the room's heating goes on
    rate = 10.8 / 3600 * (warm - 25) + 0.27 / 60 * 2**0.5 * rng.standard_normal(n)  # deg/s
    log = save(tmp_path / "mems.csv", {"t_s": t, "gz": rate, "temp": warm})
    document = diagnosed(tmp_path, str(log), "--unit-gyro", "deg/s")
    assert document["verdict"] == "established"
    (finding,) = document["findings"]
    assert finding["effect"] == "gyroscope.bias_temperature"
    assert abs(finding["coefficients"]["z"]["value"] - 10.8) < 4 * finding["coefficients"]["z"]["std"]


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.proof) for seed in range(1, 8))])
def test_a_random_walk_is_no_jump_and_no_drift(seed: int, tmp_path: Path) -> None:
    rng, n = np.random.default_rng(seed), 14_400
    t = np.arange(1, n + 1) / 2
    walk = np.cumsum(rng.standard_normal((n, 3)), axis=0) * 8 / np.sqrt(n)  # deg/h: five times the noise in 100 s
    warm = 25 + 3 * np.tanh((t - t[-1] * rng.uniform(0.2, 0.8)) / 1500)
    rate = walk / 3600 + 0.27 / 60 * 2**0.5 * rng.standard_normal((n, 3))
    columns = {"t_s": t, **{f"g{a}": rate[:, i] for i, a in enumerate("xyz")}, "temp": warm}
    document = diagnosed(tmp_path, str(save(tmp_path / "walk.csv", columns)), "--unit-gyro", "deg/s")
    assert [each["effect"] for each in document["findings"] if each["confidence"] == "established"] == []


def test_a_coefficient_beyond_belief_is_named_with_its_size(tmp_path: Path) -> None:
    rng, n = np.random.default_rng(2), 14_400
    t = np.arange(1, n + 1) / 2
    warm = 25 + 0.1 * np.sin(2 * np.pi * t / t[-1])  # a tenth of a degree moves 40 deg/h
    rate = 400 * (warm - 25) + 6 * rng.standard_normal(n)  # deg/h
    log = save(tmp_path / "fog.csv", {"t_s": t, "gz": rate, "temp": warm})
    document = diagnosed(tmp_path, str(log), "--unit-gyro", "deg/h")
    (finding,) = document["findings"]
    assert finding["effect"] == "gyroscope.bias_temperature"
    assert finding["times_expected"] > 10


def test_the_thermal_sweep_of_a_mems_accelerometer_in_one_line(tmp_path: Path) -> None:
    log = DATA / "foreign/thermal_sweep_accelerometer/log.csv"
    if not log.is_file():
        pytest.skip(f"no shared data at {DATA}: set STATION_DATA")
    document = diagnosed(tmp_path, str(log))
    assert document["error"][0]["before"] == pytest.approx(11.8e-3, rel=0.02)  # its README: constant 11.8 mg
    assert document["error"][0]["held_out_after"] < 1.05 * 1.0e-3  # a cubic with a first-order lag, by hand 1.0 mg
    p = document["probabilities"]
    assert p["accelerometer.temperature_lag"] + p["a function of temperature, accelerometer"] > 0.9
