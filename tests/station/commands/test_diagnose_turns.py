"""``station diagnose`` of turns that determine no calibration: one turn, a half turn, an encoder next to it."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station import cli
from station.errors import DataRefused
from station.files.logs.log_campaign import LogOptions, campaign_of_logs
from station.files.logs.log_columns import ColumnOptions
from tests.refusals import refused

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


def test_one_turn_alone_has_a_scale_factor_and_says_what_it_does_not_show(tmp_path: Path) -> None:
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


@pytest.mark.parametrize(
    ("turned_deg", "scale", "kind"),
    [
        (366.76, 1.004, "turn:+z:366.76deg"),
        (180.0, 0.99, "turn:+z:0.5"),
        (720.0, 1.03, "turn:+z:2"),
    ],
)
def test_a_rotation_whose_true_angle_is_specified_has_a_scale_factor(
    turned_deg: float, scale: float, kind: str, tmp_path: Path
) -> None:
    (turn,) = diagnosed(saved(tmp_path, turned_deg, scale), "--as", kind)["turns"]
    found = turn["scale_factor"]
    assert abs(found["value"] - scale) < 4 * found["std"] < 2e-3
    assert abs(turn["angle_deg"]) == pytest.approx(turned_deg)


@pytest.mark.parametrize(("turned_deg", "scale"), [(360.0, 1.0188), (180.0, 1.0)])
def test_an_angle_that_nobody_specified_is_asked_for_and_not_rounded(
    turned_deg: float, scale: float, tmp_path: Path
) -> None:
    log = saved(tmp_path, turned_deg, scale)
    with refused(DataRefused, ErrorCode.TURN_ANGLE, "turn:+z:") as asked:
        campaign_of_logs([log], LogOptions(kinds=("turn:+z",)))
    reported = re.search(r"[0-9.]+(?= deg)", str(asked.value))
    assert reported is not None
    assert float(reported[0]) == pytest.approx(turned_deg * scale, abs=0.1)
    with refused(DataRefused, ErrorCode.TURN_ANGLE):
        campaign_of_logs([log], LogOptions(ColumnOptions(unit_gyro="raw"), kinds=("turn:+z",)))


@pytest.mark.parametrize(("turned_deg", "scale"), [(366.76, 1.01), (180.0, 0.98)])
@pytest.mark.parametrize("rows", [1, 300])
def test_a_reference_angle_read_at_both_ends_alone_is_the_turns(
    turned_deg: float, scale: float, rows: int, tmp_path: Path
) -> None:
    log = saved(tmp_path, turned_deg, scale)
    head, *lines = log.read_text().splitlines()
    kept = [
        line if not rows <= i < len(lines) - rows else f"{line.rpartition(',')[0]},"
        for i, line in enumerate(lines)
    ]
    log.write_text("\n".join([head, *kept]))
    (turn,) = diagnosed(log, "--reference", "enc_deg")["turns"]
    assert turn["angle_deg"] == pytest.approx(turned_deg, abs=0.02)
    found = turn["scale_factor"]
    assert abs(found["value"] - scale) < 4 * found["std"] + 0.01 / turned_deg  # an encoder of 0.002 deg a row


def with_reference(log: Path, ends: tuple[float, float], sign: int = 1) -> Path:
    """Put a reference that was read at both ends alone into a log, and give the gyroscope a sign."""
    head, *lines = log.read_text().splitlines()
    n, rows = len(lines), [line.split(",") for line in lines]
    read = [f"{ends[i > n / 2]:.3f}" if not 300 <= i < n - 300 else "" for i in range(n)]
    kept = [f"{t},{sign * float(g):.6f},{angle}" for (t, g, _), angle in zip(rows, read, strict=True)]
    log.write_text("\n".join([head, *kept]))
    return log


@pytest.mark.parametrize("ends", [(10.0, 16.76), (16.76, 10.0)])
def test_a_reference_that_counts_the_other_way_is_turned_round(ends: tuple[float, float], tmp_path: Path) -> None:
    sign = -1 if ends[1] > ends[0] else 1
    log = with_reference(saved(tmp_path, 366.76, 1.001), ends, sign)
    found = diagnosed(log, "--reference", "enc_deg")
    assert any("counts in the opposite direction" in each for each in found["guessed"])
    (turn,) = found["turns"]
    assert turn["axis"] == ("+z" if sign > 0 else "-z")
    assert abs(turn["angle_deg"]) == pytest.approx(366.76)
    assert turn["scale_factor"]["value"] == pytest.approx(1.001, abs=2e-3)


@pytest.mark.parametrize(
    ("turned_deg", "scale", "ends", "sign", "kinds"),
    [
        (54366.76, 1.004, (10.0, 16.76), 1, ()),  # 151 turns: more than one number of them fits
        (7206.76, 1.02, (10.0, 16.76), 1, ()),  # 20 turns of a gyroscope that nobody calibrated
        (1083.3, 1.0, (3.3, 0.0), 1, ()),  # 1076.7 deg, or 1083.3 by a reference that counts the other way
        (366.76, 1.0, (0.0, 200.0 + 366.76), -1, ()),  # the other way, and another angle
        (366.76, 1.0, (0.0, 366.76), -1, ("rate:z",)),  # against what was specified
    ],
)
def test_a_reference_and_a_gyroscope_that_agree_on_no_single_angle_are_asked_about(
    turned_deg: float, scale: float, ends: tuple[float, float], sign: int, kinds: tuple[str, ...], tmp_path: Path
) -> None:
    log = with_reference(saved(tmp_path, turned_deg, scale), ends, sign)
    stated = LogOptions(ColumnOptions(reference="enc_deg"), kinds=kinds)
    with refused(DataRefused, ErrorCode.TURN_ANGLE):
        campaign_of_logs([log], stated)


def test_an_encoder_with_a_turn_of_any_angle_gives_the_scale_factor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = diagnosed(saved(tmp_path, 777.0, scale=1.03, late_s=0.05), "--reference", "enc_deg")
    scale = found["solution"]["rate_tables"]["gyroscope"]["scale_factor"]["z"]
    assert abs(scale["value"] - 1.03) < 4 * scale["std"]
    assert found["verdict"] == "consistent"
    reported = capsys.readouterr().err
    assert "ms late" in reported
    assert "1.03 times" in reported


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
    ("unit", "bias", "reported"), [(1.0, 0.003, ""), (np.pi / 180, 0.0, "0.01745 times"), (1.0, 1.0, "1.1 times")]
)
def test_a_motor_that_keeps_one_rate_is_held_against_the_whole_angle_and_is_no_rate_table(
    unit: float, bias: float, reported: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = steady(tmp_path, unit, bias, PERIOD * np.arange(6000))
    assert cli.run(["diagnose", str(log), *STEADY]) == 5
    stated = capsys.readouterr().err
    assert (reported in stated) if reported else (" times " not in stated)


def test_a_log_with_turns_that_nobody_declared_is_a_soak_only_where_it_rests(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng, t = np.random.default_rng(5), np.arange(0.0, 400.0, 0.02)
    turned = -30.0 * ((t > 100) & (t < 124)) + 30.0 * ((t > 150) & (t < 174))
    gyro = BIAS_DEG_S + turned + NOISE * rng.standard_normal(len(t))
    log = tmp_path / "spun.csv"
    np.savetxt(log, np.column_stack((t, gyro)), "%.6f", ",", header="t_s,gz_deg_s", comments="")
    found = diagnosed(log)
    (guess,) = [each for each in found["guessed"] if "it turns" in each]
    assert "225 s" in guess
    assert "--as turn:-z" in guess
    (alone,) = found["channels"]
    assert alone["random_walk"]["value"] == pytest.approx(60 * NOISE * 0.02**0.5, rel=0.1)  # deg/sqrt(h)
    assert abs(alone["drift"]["value"]) < 4 * alone["drift"]["std"]
    restless = np.column_stack((t, gyro + 20 * np.sin(t)))
    np.savetxt(log, restless, "%.6f", ",", header="t_s,gz_deg_s", comments="")
    capsys.readouterr()
    assert cli.run(["diagnose", str(log)]) == 3
    assert "--as turn:+z" in capsys.readouterr().err.splitlines()[-1]
