"""``station diagnose`` of turns that determine no calibration: one turn, a half turn, an encoder beside it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station import cli

PERIOD, SPEED, REST_S, NOISE = 0.01, 30.0, 15.0, 0.01  # s, deg/s, s, deg/s a sample
BIAS_DEG_S = 0.003


def saved(folder: Path, turned_deg: float, scale: float = 1.0, late_s: float = 0.0) -> Path:
    """Write a log of a one-axis gyroscope and an encoder that begins again at each turn."""
    seconds = 2 * turned_deg / SPEED
    t = PERIOD * np.arange(round((2 * REST_S + seconds) / PERIOD))

    def angle(at: np.ndarray) -> np.ndarray:
        x = np.clip((at - REST_S) / seconds, 0, 1)
        found: np.ndarray = turned_deg * (x - np.sin(2 * np.pi * x) / (2 * np.pi))
        return found

    rng = np.random.default_rng(1)
    rate = (angle(t + 1e-4) - angle(t - 1e-4)) / 2e-4
    gyro = scale * rate + BIAS_DEG_S + NOISE * rng.standard_normal(len(t))
    encoder = np.mod(angle(t - late_s) + 0.002 * rng.standard_normal(len(t)), 360)
    file = folder / "turn.csv"
    table = np.stack((t, gyro, encoder), axis=1)
    np.savetxt(file, table, fmt="%.6f", delimiter=",", header="t_s,gz_deg_s,enc_deg", comments="")
    return file


def diagnosed(log: Path, *options: str) -> dict[str, Any]:
    out = log.parent / "out.json"
    assert cli.run(["diagnose", str(log), *options, "--json", str(out)]) == 0
    found: dict[str, Any] = json.loads(out.read_text())
    return found


def test_one_turn_alone_has_a_scale_factor_and_says_what_it_does_not_show(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = saved(tmp_path, 1080.0, scale=1.0005)
    found = diagnosed(log, "--as", "turn:+z")
    assert "solution" not in found
    (turn,) = found["turns"]
    scale = turn["scale_factor"]
    assert abs(scale["value"] - 1.0005) < 4 * scale["std"] < 2e-3
    assert turn["at_rest"]["unit"] == "deg/h"
    assert abs(turn["at_rest"]["value"] - 3600 * BIAS_DEG_S) < 4 * turn["at_rest"]["std"]
    assert abs(turn["beyond_whole_turns"]["value"] - 0.54) < 4 * turn["beyond_whole_turns"]["std"]
    assert any("direction" in each for each in found["turns_leave_open"])
    capsys.readouterr()
    assert cli.run(["diagnose", str(log), "--as", "turn:+z"]) == 0
    said = capsys.readouterr().out
    assert "scale factor        1.000" in said
    assert max(map(len, said.splitlines())) <= 80


def test_a_half_turn_has_an_angle(tmp_path: Path) -> None:
    (turn,) = diagnosed(saved(tmp_path, 180.0), "--as", "turn:+z")["turns"]
    assert "scale_factor" not in turn
    assert abs(turn["turned"]["value"] - 180.0) < 4 * turn["turned"]["std"]


@pytest.mark.parametrize("turned_deg", [180.0, 777.0])
def test_an_encoder_beside_a_turn_of_any_angle_gives_the_scale_factor(
    turned_deg: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = diagnosed(saved(tmp_path, turned_deg, scale=1.03, late_s=0.05), "--reference", "enc_deg")
    scale = found["solution"]["rate_tables"]["gyroscope"]["scale_factor"]["z"]
    assert abs(scale["value"] - 1.03) < 4 * scale["std"]
    assert found["verdict"] == "consistent"
    said = capsys.readouterr().err
    assert "enc_deg is an angle" in said
    assert "ms late: taken out" in said
    assert "1.03 times as far as enc_deg" in said


def test_an_angle_that_never_changes_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "still.csv"
    rows = [f"{0.01 * i:.2f},{0.001 * (i % 3)},5" for i in range(500)]
    log.write_text("\n".join(["t_s,gz_deg_s,enc_deg", *rows]))
    assert cli.run(["diagnose", str(log), "--reference", "enc_deg"]) == 3
    assert "enc_deg that never changes" in capsys.readouterr().err


def steady(folder: Path, unit: float, bias: float, t: np.ndarray) -> Path:
    """Write a log of a motor at 10 deg/s, an encoder of 0.01 deg, outputs of so many a deg/s, and a temperature.

    Only every tenth row has a temperature.
    """
    rng = np.random.default_rng(4)
    gyro = unit * (10.0 + bias + NOISE * rng.standard_normal(len(t)))
    encoder = np.round(10.0 * t, 2)
    rows = [f"{a:.4f},{b:.9f},{c:.2f}," for a, b, c in zip(t, gyro, encoder, strict=True)]
    rows = [f"{row}{20 + 0.1 * i:.2f}" if i % 10 == 0 else row for i, row in enumerate(rows)]
    file = folder / "motor.csv"
    file.write_text("\n".join(["t_s,gz,enc_deg,temp_c", *rows]))
    return file


STEADY = ("--reference", "enc_deg", "--unit-gyro", "deg/s", "--as", "rate:z")


@pytest.mark.parametrize(
    ("unit", "bias", "said"), [(1.0, 0.003, ""), (np.pi / 180, 0.0, "0.01745 times"), (1.0, 1.0, "1.1 times")]
)
def test_a_motor_that_keeps_one_rate_is_held_against_the_whole_angle_and_is_no_rate_table(
    unit: float, bias: float, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = steady(tmp_path, unit, bias, PERIOD * np.arange(6000))
    assert cli.run(["diagnose", str(log), *STEADY]) == 5
    told = capsys.readouterr().err
    assert (said in told) if said else ("times as far" not in told)
    assert ("their bias is large" in told) == bool(said)
    assert "points at rates that differ by more than 1 %" in told.splitlines()[-1]


def test_rows_dense_at_one_end_are_refused_without_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.concatenate((np.linspace(0, 1, 50, endpoint=False), np.arange(1.0, 31.0)))
    assert cli.run(["diagnose", str(steady(tmp_path, 1.0, 0.0, t)), *STEADY]) == 5
    told = capsys.readouterr().err
    assert "Warning" not in told
    assert "late" not in told


def test_a_log_that_turns_and_nobody_told_of_is_a_soak_only_where_it_rests(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng, t = np.random.default_rng(5), np.arange(0.0, 400.0, 0.02)
    turned = -30.0 * ((t > 100) & (t < 124)) + 30.0 * ((t > 150) & (t < 174))
    gyro = BIAS_DEG_S + turned + NOISE * rng.standard_normal(len(t))
    log = tmp_path / "spun.csv"
    np.savetxt(log, np.column_stack((t, gyro)), "%.6f", ",", header="t_s,gz_deg_s", comments="")
    found = diagnosed(log)
    (guess,) = [each for each in found["guessed"] if "it turns" in each]
    assert guess.startswith(
        "spun.csv: it turns, by up to 30 deg/s about z: only the 225 s at rest from 175.0 s on"
    )
    assert guess.endswith("say --as turn:-z, or --reference COL of a rate table")
    (alone,) = found["channels"]
    assert alone["random_walk"]["value"] == pytest.approx(60 * NOISE * 0.02**0.5, rel=0.1)  # deg/sqrt(h)
    assert abs(alone["drift"]["value"]) < 4 * alone["drift"]["std"]
    restless = np.column_stack((t, gyro + 20 * np.sin(t)))
    np.savetxt(log, restless, "%.6f", ",", header="t_s,gz_deg_s", comments="")
    capsys.readouterr()
    assert cli.run(["diagnose", str(log)]) == 3
    told = capsys.readouterr().err
    assert "about z: taken for a soak all the same; say --as turn:" in told
    assert "and no rest of 10 s, expected a log that rests; say what it is: --as turn:+z" in told.splitlines()[-1]
