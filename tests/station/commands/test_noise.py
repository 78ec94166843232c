"""``station noise``: a log's noise as text, JSON, page and PNG; what it refuses."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station import cli
from tests.paths import DATA

N, PERIOD = 20_000, 0.01
WALK = 0.003  # deg/s sqrt(s): 0.18 deg/sqrt(h)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng, t = np.random.default_rng(1), PERIOD * np.arange(1, N + 1)
    gyro = WALK / np.sqrt(PERIOD) * rng.normal(size=N) + 0.02 * np.sin(2 * np.pi * 21.3 * t)
    file = tmp_path_factory.mktemp("log") / "fog.csv"
    np.savetxt(
        file, np.stack((t, gyro, np.full(N, 0.5)), axis=1), "%.8g", ",", header="t,wx_deg_s,wy_deg_s", comments=""
    )
    return file


def test_a_log_s_random_walk_and_line_are_reported_and_a_constant_channel_is_left_out(
    log: Path, tmp_path: Path
) -> None:
    out, page, png = tmp_path / "out.json", tmp_path / "out.html", tmp_path / "out.png"
    assert cli.run(["noise", str(log), "--json", str(out), "--html", str(page), "--png", str(png)]) == 0
    document = json.loads(out.read_text())
    (channel,) = document["channels"]
    walk = channel["terms"]["random_walk"]
    assert walk["unit"] == "deg/sqrt(h)"
    assert walk["low"] < 60 * WALK < walk["high"]
    (line,) = channel["lines"]
    assert line["hertz"] == pytest.approx(21.3, abs=4 * line["hertz_std"])
    assert line["amplitude"] == pytest.approx(72.0, abs=4 * line["amplitude_std"])  # deg/h
    assert document["left_out"] == ["gyroscope y: never changes"]
    assert page.read_text().count("<svg") == 1
    assert png.read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not (DATA / "campaigns").is_dir(), reason="no campaigns at hand")
def test_a_campaign_s_counts_are_scaled_by_its_own_solution(tmp_path: Path) -> None:
    out = tmp_path / "out.json"
    assert cli.run(["noise", str(DATA / "campaigns/clean"), "--json", str(out)]) == 0
    channels = {each["channel"]: each for each in json.loads(out.read_text())["channels"]}
    walk = channels["gyroscope x"]["terms"]["random_walk"]
    assert walk["unit"] == "deg/sqrt(h)"
    assert 0.004 < walk["value"] < 0.008


def _noise(tmp_path: Path, rate: np.ndarray[tuple[int], np.dtype[np.float64]], hertz: float) -> dict[str, Any]:
    """Return the one channel of the `noise/1` of a log in deg/s."""
    file, out = tmp_path / "log.csv", tmp_path / "out.json"
    t = np.arange(len(rate)) / hertz
    np.savetxt(file, np.stack((t, rate), axis=1), ("%.4f", "%.6f"), ",", header="t_s,gx_dps", comments="")
    assert cli.run(["noise", str(file), "--json", str(out)]) == 0
    (channel,) = json.loads(out.read_text())["channels"]
    return dict(channel)


def test_noise_below_a_step_is_bounded_and_the_rest_is_not_determined(tmp_path: Path) -> None:
    counts = np.round(0.2 * np.random.default_rng(8).normal(size=2400) + 0.3)
    channel = _noise(tmp_path, counts / 131, 20.0)
    assert [each["name"] for each in channel["conditions"]] == ["coarse_levels"]
    walk, unit = channel["terms"]["random_walk"], 60 / 131 / np.sqrt(20)
    assert 0.2 * unit < walk.get("below", walk.get("high")) < 0.35 * unit
    assert channel["terms"]["bias_instability"]["value"] is None


def test_samples_held_by_a_fast_logger_are_analysed_at_the_rate_of_the_sensor(tmp_path: Path) -> None:
    sensor = 0.1 * np.random.default_rng(9).normal(size=2000)
    channel = _noise(tmp_path, np.repeat(sensor, 10), 1000.0)
    assert [each["name"] for each in channel["conditions"]] == ["held_samples"]
    assert channel["conditions"][0]["values"]["rows"] == pytest.approx(10)
    assert channel["conditions"][0]["values"]["sensor_hz"] == pytest.approx(100)
    walk = channel["terms"]["random_walk"]
    assert walk["low"] < 0.1 / np.sqrt(100) * 60 < walk["high"]


@pytest.mark.parametrize("every", [15, 20, 50])
def test_a_triad_of_few_measured_rows_is_left_out(tmp_path: Path, every: int) -> None:
    rng = np.random.default_rng(3)
    rows = [
        f"{i / 100:.2f},{','.join(f'{x:.6f}' for x in rng.normal(size=3))},"
        + (",".join(f"{x:.6f}" for x in rng.normal(size=3)) if i % every == 0 else ",,")
        for i in range(150)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["t,gx_deg_s,gy_deg_s,gz_deg_s,ax_g,ay_g,az_g", *rows]) + "\n")
    out = tmp_path / "out.json"
    assert cli.run(["noise", str(tmp_path / "log.csv"), "--json", str(out)]) == 0
    channels = {each["channel"] for each in json.loads(out.read_text())["channels"]}
    assert {"gyroscope x", "gyroscope y", "gyroscope z"} <= channels
