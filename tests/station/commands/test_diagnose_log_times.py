"""A log whose time base is wrong beside UTC, and a sensor that follows a thermometer: in one line each."""

import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station import cli

N, SLOW_PPM = 18_000, 800.0
TRUE = np.arange(1, N + 1) / 10.0  # s


def moments(utc: FloatArray) -> list[str]:
    return [datetime.fromtimestamp(float(each), UTC).isoformat(timespec="milliseconds") for each in utc]


@pytest.mark.parametrize("name", ["utc", "utc_ms", "gps"])
def test_a_log_s_slow_clock_is_found_by_the_utc_of_its_rows(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(1)
    utc = 1.7e9 + TRUE + 2e-3 * rng.standard_normal(N)
    said = {"utc": moments(utc), "utc_ms": [f"{1e3 * u:.3f}" for u in utc], "gps": [f"{u:.6f}" for u in utc]}[name]
    log, out = tmp_path / "log.csv", tmp_path / "out.json"
    rows = zip(TRUE * (1 - SLOW_PPM * 1e-6), said, 0.01 * rng.standard_normal(N), strict=True)
    log.write_text(f"t,{name},gz\n" + "\n".join(f"{t:.6f},{u},{g:.6f}" for t, u, g in rows))
    told = ["--utc", "gps"] if name == "gps" else []
    assert cli.run(["diagnose", str(log), "--unit-gyro", "deg/s", *told, "--json", str(out)]) == 0
    (finding,) = json.loads(out.read_text())["findings"]
    assert (finding["effect"], finding["confidence"]) == ("clock.rate", "established")
    found = finding["coefficients"]["value"]
    assert abs(found["value"] + SLOW_PPM) < 4 * found["std"] + 0.05
    assert ("UTC is" in capsys.readouterr().err) is (name != "gps")


def test_a_sensor_that_follows_a_thermometer_has_its_time_constant_in_seconds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng, t = np.random.default_rng(2), np.arange(0, 4 * 3600, 1.0)
    warm = 25 + 20 * np.sin(2 * np.pi * t / 7200)
    sensor = np.empty_like(warm)
    sensor[0] = warm[0]
    for i in range(1, len(t)):
        sensor[i] = sensor[i - 1] + (warm[i] - sensor[i - 1]) / 900.0
    f = 9.80665 * (1 + 120e-6 * (sensor - 25)) + 2e-4 * rng.standard_normal(len(t))
    log = tmp_path / "oven.csv"
    columns = np.column_stack((t, f, warm))
    np.savetxt(log, columns, "%.9g", ";", header="t [s];acc_z [m/s2];T [degC]", comments="")
    assert cli.run(["diagnose", str(log)]) == 0
    told = capsys.readouterr()
    assert "temperature is T [degC]" in told.err
    assert "ESTABLISHED. The model lacked accelerometer.temperature_lag" in told.out
    (line,) = [line.split() for line in told.out.splitlines() if line.strip().startswith("tau_s ")]
    assert line[4] == "s"
    # in steps of 1 s, of which each takes the newest temperature, a step in 900 follows 899 s late
    assert abs(float(line[1]) - 899.0) < 4 * float(line[3])


@pytest.mark.parametrize("rates", [(10, 5), (10, 10, 5), (5, 100, 100)])
def test_logs_of_different_rates_are_each_read_at_its_own(
    rates: tuple[int, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng, logs = np.random.default_rng(3), list[str]()
    for i, rate in enumerate(rates):
        t = np.arange(300 * rate) / rate
        gz = 9.0 + 0.05 * 60 * np.sqrt(rate) * rng.standard_normal(len(t))  # 0.05 deg/sqrt(h)
        log = tmp_path / f"log{i}.csv"
        np.savetxt(log, np.column_stack((t, gz)), "%.5f", ",", header="t_s,gz_deg_h", comments="")
        logs.append(str(log))
    out, folder = tmp_path / "out.json", tmp_path / "kept"
    assert cli.run(["diagnose", *logs, "--json", str(out)]) == 0
    found = json.loads(out.read_text())
    assert not [line for line in found["warnings"] if "sample_period_s" in line or "gap" in line]
    (noise,) = found["noise"]
    assert noise["terms"]["random_walk"]["value"] == pytest.approx(0.05, rel=0.1)
    capsys.readouterr()
    assert cli.run(["diagnose", *logs, "--campaign", str(folder)]) == 3
    said = ", ".join(str(rate) for rate in rates)
    assert f"found logs of {said} Hz, expected one sample rate" in capsys.readouterr().err
    assert not folder.exists()


def test_logs_of_two_rates_that_are_read_in_bursts_keep_their_own(tmp_path: Path) -> None:
    rng, logs = np.random.default_rng(4), list[str]()
    for rate in (10, 50):
        t = np.arange(1, 400 * rate + 1) / rate
        read = np.ceil(t / 0.7) * 0.7 + 1e-4 * (np.arange(len(t)) % 100)  # a read brings all since the last one
        log = tmp_path / f"log{rate}.csv"
        gz = 9.0 + 3 * np.sqrt(rate) * rng.standard_normal(len(t))
        np.savetxt(log, np.column_stack((read, gz)), "%.5f", ",", header="t_s,gz_deg_h", comments="")
        logs.append(str(log))
    out = tmp_path / "out.json"
    assert cli.run(["diagnose", *logs, "--json", str(out)]) == 0
    (noise,) = json.loads(out.read_text())["noise"]
    assert noise["seconds"] == pytest.approx(400, rel=0.01)
    assert noise["terms"]["random_walk"]["value"] == pytest.approx(3 / 60, rel=0.1)
