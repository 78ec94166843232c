"""A log whose time base is wrong against UTC: found in one line."""

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


@pytest.mark.parametrize("name", ["utc", "gps"])
def test_a_log_s_slow_clock_is_found_by_the_utc_of_its_rows(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    utc = 1.7e9 + TRUE + 2e-3 * rng.standard_normal(N)
    reported = {"utc": moments(utc), "gps": [f"{u:.6f}" for u in utc]}[name]
    log, out = tmp_path / "log.csv", tmp_path / "out.json"
    rows = zip(TRUE * (1 - SLOW_PPM * 1e-6), reported, 0.01 * rng.standard_normal(N), strict=True)
    log.write_text(f"t,{name},gz\n" + "\n".join(f"{t:.6f},{u},{g:.6f}" for t, u, g in rows))
    stated = ["--utc", "gps"] if name == "gps" else []
    assert cli.run(["diagnose", str(log), "--unit-gyro", "deg/s", *stated, "--json", str(out)]) == 0
    (finding,) = json.loads(out.read_text())["findings"]
    assert (finding["effect"], finding["confidence"]) == ("clock.rate", "established")
    found = finding["coefficients"]["value"]
    assert abs(found["value"] + SLOW_PPM) < 4 * found["std"] + 0.05


def test_logs_of_different_rates_are_each_read_at_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rates, rng, logs = (5, 100, 100), np.random.default_rng(3), list[str]()
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
    assert "5, 100, 100 Hz" in capsys.readouterr().err
    assert not folder.exists()
