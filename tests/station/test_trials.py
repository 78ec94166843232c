"""Recordings as people have them, of kinds that are easily misread; their READMEs derive the expected values."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station.cli import run
from tests.paths import DATA, ROOT

TRIALS = DATA / "trials"
CALIBRATION = str(ROOT / "docs/examples/calibration.json")
pytestmark = pytest.mark.skipif(not TRIALS.is_dir(), reason="the shared data is not here")


def log(name: str, file: str = "log.csv") -> str:
    return str(TRIALS / name / file)


def document(tmp_path: Path, command: str, *arguments: str) -> dict[str, Any]:
    out = tmp_path / "out.json"
    assert run([command, *arguments, "--json", str(out)]) == 0
    return dict(json.loads(out.read_text(encoding="utf-8")))


def noise(tmp_path: Path, *arguments: str) -> dict[str, dict[str, Any]]:
    return {each["channel"]: each for each in document(tmp_path, "noise", *arguments)["channels"]}


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Return exit code, stable code and line of what is refused."""
    code = run([*arguments, "--verbose"])
    line = capsys.readouterr().err.splitlines()[-1]
    (stable,) = re.findall(r"\[(E-[A-Z-]+): ", line)
    return code, str(stable), line


def test_unix_milliseconds_every_two_seconds(tmp_path: Path) -> None:
    (x,) = noise(tmp_path, log("epoch_ms_every_2s")).values()
    assert x["rate_hz"] == pytest.approx(0.5)
    assert x["seconds"] == pytest.approx(3000, abs=4)


def test_ticks_of_a_tenth_of_a_millisecond(tmp_path: Path) -> None:
    made = subprocess.run(
        [sys.executable, log("xsens_sampletimefine", "make.py")], capture_output=True, text=True, check=True
    )
    (tmp_path / "xsens.csv").write_text(made.stdout, encoding="utf-8")
    (x,) = noise(tmp_path, str(tmp_path / "xsens.csv"), "--time", "SampleTimeFine").values()
    assert x["rate_hz"] == pytest.approx(100)
    assert x["terms"]["random_walk"]["value"] == pytest.approx(0.12, rel=0.03)  # deg/sqrt(h), planted


def test_microseconds_without_a_unit_are_asked_for_and_read_once_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = log("us_at_1khz_noise")
    code, stable, line = refusal(capsys, "noise", file)
    assert (code, stable) == (2, "E-TIME-UNIT")
    assert "us (1000 Hz" in line
    for x in noise(tmp_path, file, "--unit-time", "us").values():
        assert x["rate_hz"] == pytest.approx(1000)


def test_milliseconds_at_1_khz_are_asked_for_by_apply_which_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.csv"
    apply = ("apply", log("ms_at_1khz_apply"), "--calibration", CALIBRATION, "--out", str(out))
    code, stable, line = refusal(capsys, *apply)
    assert (code, stable) == (2, "E-TIME-UNIT")
    assert "ms (1000 Hz" in line
    assert run([*apply, "--unit-time", "s"]) == 3  # 0.001 g at rest contradicts gravity
    assert not out.exists()
    assert run([*apply, "--unit-time", "ms"]) == 0
    found = np.genfromtxt(out, delimiter=",", names=True)
    assert np.mean(found["f_z_m_s2"]) == pytest.approx(9.797, abs=0.01)  # one count of 1122
    assert np.mean(found["omega_z_rad_s"]) == pytest.approx(0.349, abs=0.001)


def test_scales_in_the_header_of_a_gcsv(tmp_path: Path) -> None:
    found = noise(tmp_path, log("gcsv_tscale", "log.gcsv"))
    assert {each["recording"] for each in found.values()} == {"log.gcsv"}
    assert found["gyroscope x"]["rate_hz"] == pytest.approx(400)
    assert found["gyroscope x"]["terms"]["random_walk"]["unit"] == "deg/sqrt(h)"
    assert found["accelerometer z"]["terms"]["random_walk"]["unit"] == "ug/sqrt(Hz)"


def test_gx_in_g_is_an_accelerometer(tmp_path: Path) -> None:
    found = noise(tmp_path, log("gx_in_g_is_acceleration"))
    assert set(found) == {f"accelerometer {axis}" for axis in "xyz"}
    for each in found.values():
        assert each["terms"]["random_walk"]["value"] == pytest.approx(316, rel=0.1)  # ug/sqrt(Hz), planted


@pytest.mark.parametrize("command", ["noise", "diagnose"])
def test_signed_integers_printed_unsigned(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    units = ("--unit-gyro", "131/(deg/s)", "--unit-accel", "16384/g")
    code, stable, line = refusal(capsys, command, log("int16_printed_unsigned"), *units)
    assert (code, stable) == (3, "E-UNIT")
    assert "gx, gy" in line
    assert "4.1 g" in line or "40.2 m/s2" in line


def test_increments_stated_as_accelerations(capsys: pytest.CaptureFixture[str]) -> None:
    columns = ("--time", "1", "--accel", "2,3,4", "--unit-accel", "m/s2")
    code, stable, line = refusal(capsys, "noise", log("unit_told_against_gravity", "log.txt"), *columns)
    assert (code, stable) == (3, "E-UNIT")
    assert "0.196" in line
    assert "0.02 s" in line


def test_noise_below_one_step_is_a_bound(tmp_path: Path) -> None:
    (x,) = noise(tmp_path, log("deadband_quantised")).values()
    term = x["terms"]["random_walk"]
    planted, step = 0.01536, 1 / 131 / np.sqrt(20) * 60  # deg/sqrt(h), of one count
    assert "value" not in term or term["value"] is None
    assert planted < term["below"] < 0.35 * step
    assert "coarse_levels" in {each["name"] for each in x["conditions"]}


def test_degrees_in_columns_of_radians(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, line = refusal(capsys, "attitude", log("attitude_deg_as_rad"))
    assert code == 3
    assert "deg/s" in line


def test_a_damaged_line_is_lost_and_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert noise(tmp_path, log("one_glitched_line"))
    assert "1 row is damaged and lost, first line 302" in capsys.readouterr().err


def test_rows_that_end_with_a_comma_keep_the_names_of_the_header(tmp_path: Path) -> None:
    found = document(tmp_path, "diagnose", log("trailing_comma"))
    assert any("gyro is gx_dps,gy_dps,gz_dps" in each for each in found["guessed"])


def test_j1939_frames_are_known_by_their_pgn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = TRIALS / "j1939_source_address"
    device = f"replay:{folder / 'frames_sa80.bin'}?dbc={folder / 'j1939.dbc'}&map={folder / 'j1939.toml'}"
    assert run(["record", device, "--out", str(tmp_path / "r")]) == 0
    assert "300 samples" in capsys.readouterr().out


def test_a_candump_text_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its DBC has a second message, ACC, which the recording lacks: that is refused, and what is there is read."""
    folder = tmp_path / "can"
    shutil.copytree(TRIALS / "candump_log", folder)
    device = f"replay:{folder / 'candump.log'}?dbc={folder / 'be.dbc'}&map={folder / 'be.toml'}"
    code, _, line = refusal(capsys, "record", device, "--out", str(tmp_path / "r"))
    assert code == 3
    assert "ACC (0x101)" in line
    mapping = (folder / "be.toml").read_text(encoding="utf-8")
    kept = [each for each in mapping.splitlines() if not each.startswith("accel")]
    (folder / "be.toml").write_text("\n".join(kept), encoding="utf-8")
    assert run(["record", device, "--out", str(tmp_path / "r")]) == 0
    assert "300 samples" in capsys.readouterr().out


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three logs as users have them; the planted values stand in make.py."""
    folder = tmp_path_factory.mktemp("user_logs")
    subprocess.run(
        [sys.executable, log("three_user_logs", "make.py")], cwd=folder, check=True, capture_output=True
    )
    return folder


def test_an_oven_log_is_explained_by_what_was_planted(made: Path, tmp_path: Path) -> None:
    found = document(tmp_path, "diagnose", str(made / "oven.csv"))
    named = {each["effect"]: each for each in found["findings"]}
    assert found["verdict"] in {"established", "likely", "ambiguous"}  # the lag alone is named at 0.87
    assert {"gyroscope.bias_temperature", "accelerometer.temperature_lag"} <= set(named)
    y = named["gyroscope.bias_temperature"]["coefficients"]["y"]
    assert y["value"] == pytest.approx(4.2, abs=4 * y["std"])  # deg/h/K, planted


def test_six_faces_by_hand_give_scale_factor_and_bias(made: Path, tmp_path: Path) -> None:
    solution = document(tmp_path, "diagnose", str(made / "six_faces.csv"))["solution"]
    assert set(solution["accelerometer"]) >= {"scale_factor", "bias"}
    assert sum(each.startswith("accelerometer.misalignment") for each in solution["not_observable"]) == 3


def test_an_analogue_gyroscope_on_a_rate_table(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = ("--gyro", "-,-,Vout", "--reference", "table rate", "--time", "t")
    found = document(tmp_path, "diagnose", str(made / "turntable.csv"), *columns)
    named = {each["effect"]: each["coefficients"]["z"] for each in found["findings"]}
    cubic, asymmetry = named["gyroscope.scale_nonlinearity"], named["gyroscope.scale_asymmetry"]
    assert cubic["value"] == pytest.approx(0.16, abs=4 * cubic["std"])  # ppm/(deg/s)^2: 1600 ppm at 100 deg/s
    assert asymmetry["value"] == pytest.approx(900, abs=4 * asymmetry["std"])  # 450 ppm either side
    assert run(["diagnose", str(made / "turntable.csv"), *columns]) == 0
    reported = capsys.readouterr().out
    assert re.search(r"scale factor z\s+12\.39\d+ \+- \S+ mV/\(deg/s\)", reported)
    assert re.search(r"offset z\s+250[23]\.\d+ \+- \S+ mV", reported)
