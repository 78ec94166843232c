"""`station attitude` and `station tune` of a log with truth: every aid, and what a diagnosis names."""

import json
from pathlib import Path

import numpy as np
import pytest

from station.cli import run
from tests.procedures.attitude.driving import with_truth

G = 9.80665


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Ten seconds of rolling at constant speed, with truth, an airspeed and a gap."""
    t = np.concatenate([np.arange(0, 5, 0.01), np.arange(5.5, 10, 0.01)])
    roll = 0.5 * np.sin(t)
    columns = [
        t,
        0.5 * np.cos(t),
        0 * t,
        0 * t,
        0 * t,
        -G * np.sin(roll),
        -G * np.cos(roll),
        30 + 0 * t,
        roll,
        0 * t,
    ]
    path = tmp_path / "log.csv"
    header = "t_s,p_rad_s,q_rad_s,r_rad_s,fx_m_s2,fy_m_s2,fz_m_s2,airspeed_m_s,roll_rad,pitch_rad"
    np.savetxt(path, np.stack(columns, axis=1), "%.9g", ",", header=header, comments="")
    return path


@pytest.mark.parametrize(
    "aid", ["none", "airspeed", "airspeed-filter", "paper-airspeed", "paper-airspeed-rate", "paper-filter"]
)
def test_every_aid_writes_the_contract(log: Path, tmp_path: Path, aid: str) -> None:
    out, reported = tmp_path / "out.csv", tmp_path / "out.json"
    assert run(["attitude", str(log), "--aid", aid, "--out", str(out), "--json", str(reported)]) == 0
    table = np.genfromtxt(out, delimiter=",", names=True)
    assert table.dtype.names == ("t_s", "roll_rad", "pitch_rad", "down_x", "down_y", "down_z")
    assert len(table) == 950
    down = np.stack([table["down_x"], table["down_y"], table["down_z"]], axis=1)
    assert np.abs(np.linalg.norm(down, axis=1) - 1).max() < 1e-6
    assert np.allclose(np.arctan2(table["down_y"], table["down_z"]), table["roll_rad"], atol=1e-6)
    document = json.loads(reported.read_text())
    assert document["format"] == "attitude/1"
    assert document["aid"] == aid
    assert document["rows"] == 950
    assert document["gaps"] == [[pytest.approx(4.99), pytest.approx(5.5)]]
    assert len(document["gyro_bias_rad_s"]["value"]) == 3
    assert set(document["rms_deg"]) == {"roll", "pitch", "inclination"}
    assert document["rms_deg"]["inclination"] < 8
    assert any("4.99 s" in warning for warning in document["warnings"])


def test_without_an_aid_the_best_is_taken_and_both_directions_are_better(log: Path, tmp_path: Path) -> None:
    reported = tmp_path / "out.json"
    assert run(["attitude", str(log), "--json", str(reported)]) == 0
    online = json.loads(reported.read_text())
    assert (online["aid"], online["direction"]) == ("airspeed-filter", "forwards")
    out = tmp_path / "out.csv"
    assert run(["attitude", str(log), "--direction", "both", "--out", str(out), "--json", str(reported)]) == 0
    assert len(np.genfromtxt(out, delimiter=",", names=True)) == 950
    assert json.loads(reported.read_text())["sigma_deg"] < online["sigma_deg"]
    assert run(["attitude", str(log), "--aid", "none", "--tau", "10", "--json", str(reported)]) == 0
    assert json.loads(reported.read_text())["parameters"]["k1"] == pytest.approx(0.2)  # 2 / tau


@pytest.mark.parametrize("command", [["attitude", "--out"], ["attitude", "--json"], ["tune", "--json"]])
def test_the_log_is_never_written_over_by_whatever_path_it_is_named(log: Path, command: list[str]) -> None:
    before, link = log.read_bytes(), log.with_name("link.csv")
    link.symlink_to(log)
    for read, written in ((log, log), (link, log), (log, log.parent / "x" / ".." / log.name)):
        (log.parent / "x").mkdir(exist_ok=True)
        assert run([command[0], str(read), command[1], str(written)]) == 2
    assert log.read_bytes() == before


def test_tune_shows_the_curve_and_writes_it(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["tune", str(log), "--aid", "airspeed"]) == 0
    assert "--tau" in capsys.readouterr().out
    reported = tmp_path / "out.json"
    assert run(["tune", str(log), "--gains", "--json", str(reported)]) == 0
    document = json.loads(reported.read_text())
    assert document["format"] == "tuning/1"
    assert len(document["curve"]) == 63
    assert run(["tune", str(log), "--aid", "gnss"]) == 2


def test_diagnose_names_what_the_model_lacks(tmp_path: Path) -> None:
    log = with_truth()
    assert log.airspeed is not None
    assert log.roll is not None
    assert log.pitch is not None
    path, reported = tmp_path / "drive.csv", tmp_path / "out.json"
    table = np.column_stack(
        [log.t, log.omega_b, log.f_b + np.array([0.05, 0, 0]), log.airspeed, log.roll, log.pitch]
    )
    header = "t_s,p_rad_s,q_rad_s,r_rad_s,fx_m_s2,fy_m_s2,fz_m_s2,airspeed_m_s,roll_rad,pitch_rad"
    np.savetxt(path, table, "%.9g", ",", header=header, comments="")
    assert run(["attitude", str(path), "--diagnose", "--json", str(reported)]) == 0
    document = json.loads(reported.read_text())
    found = document["diagnosis"]
    assert found["format"] == "diagnosis/2"
    assert found["verdict"] == "established"
    assert found["findings"][0]["effect"] == "accelerometer.bias"
    assert found["findings"][0]["kind"] == "instrument"
    assert found["findings"][0]["coefficients"]["x"]["value"] == pytest.approx(0.05, abs=0.01)
    assert found["error"][0]["held_out_after"] < found["error"][0]["held_out_before"]
