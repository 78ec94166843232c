"""What ``station diagnose LOG`` says in words: of what is not used, not enough, dead, wrong, or solved."""

import json
from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.frames import rotation
from station import cli

RATE = 50
NAMES = "gx,gy,gz,ax,ay,az"
OPTIONS = (
    "--rate",
    str(RATE),
    "--gyro",
    "gx,gy,gz",
    "--accel",
    "ax,ay,az",
    "--unit-gyro",
    "deg/s",
    "--unit-accel",
    "g",
)


def at_rest(seconds: float) -> FloatArray:
    n = int(seconds * RATE)
    return np.random.default_rng(1).standard_normal((n, 6)) * [*[0.05] * 3, *[1e-3] * 3] + [0, 0, 0, 0, 0, 1.0]


def written(folder: Path, table: FloatArray, names: str = NAMES) -> str:
    np.savetxt(folder / "log.csv", table, "%.8g", ",", header=names, comments="")
    return str(folder / "log.csv")


def sequence() -> tuple[FloatArray, FloatArray]:
    """Twenty rests moved to by hand, of a unit with scale factors and biases (2, 3) that it returns as well."""
    rng, C, parts = np.random.default_rng(3), np.eye(3), list[FloatArray]()
    scale, bias = (
        np.array([[1.01, 0.99, 1.005], [1.02, 0.98, 1.0]]),
        np.array([[0.3, -0.2, 0.1], [0.02, -0.01, 0.03]]),
    )
    for _ in range(20):
        parts.append(np.tile([0, 0, 0, *C[:, 2]], (8 * RATE, 1)))
        turn = rng.standard_normal(3)
        turn *= rng.uniform(0.8, 2.0) / np.linalg.norm(turn)
        for k in range(2 * RATE):
            w = turn / 2 * (1 - np.cos(np.pi * (k + 0.5) / RATE))
            C = rotation(-w / RATE) @ C
            parts.append(np.array([[*np.degrees(w), *C[:, 2]]]))
    table = np.vstack(parts) * scale.ravel() + bias.ravel()
    return table + at_rest(len(table) / RATE) - [0, 0, 0, 0, 0, 1.0], np.stack([scale, bias])


def test_a_short_rest_is_not_enough_and_what_would_be_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["diagnose", written(tmp_path, at_rest(200 / RATE)), *OPTIONS]) == 0
    reported = capsys.readouterr().out
    assert reported.startswith("NOT ENOUGH DATA TO CALIBRATE.")
    assert "384 samples or 200 s" in reported


def test_where_every_channel_is_dead_that_is_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = np.tile([0.1, 0.2, 0.3, 0.01, 0.02, 1.0], (500 * RATE, 1))
    assert cli.run(["diagnose", written(tmp_path, table), *OPTIONS]) == 5
    assert "accelerometer x, " in capsys.readouterr().err


def test_the_calibration_of_rests_and_moves_is_that_of_the_truth(tmp_path: Path) -> None:
    table, true = sequence()
    out, log = tmp_path / "out.json", written(tmp_path, table)
    assert cli.run(["diagnose", log, *OPTIONS, "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    for triad, i in (("gyroscope", 0), ("accelerometer", 1)):
        found = document["solution"][triad]["scale_factor"]
        assert np.all(np.abs(np.array(found["value"]) - true[0, i]) < 5 * np.array(found["std"]))


@pytest.mark.parametrize(
    ("backwards", "reported"),
    [
        ("z", "gyroscope z counts backwards: its scale factor is negative to that of the others"),
        ("xy", "gyroscopes x and y count backwards, or accelerometer z does"),
        ("", ""),
    ],
)
def test_a_gyroscope_that_counts_backwards_is_a_warning(backwards: str, reported: str, tmp_path: Path) -> None:
    table, out = sequence()[0], tmp_path / "out.json"
    table[:, ["xyz".index(axis) for axis in backwards]] *= -1
    assert cli.run(["diagnose", written(tmp_path, table), *OPTIONS, "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    found = [text for text in document["solution"]["warnings"] if "backwards" in text]
    assert [text.startswith(reported) for text in found] == [True] * bool(reported)
    own = np.diag(document["solution"]["gyroscope"]["misalignment"]["value"])
    assert np.all(np.sign(own) == [-1 if axis in backwards else 1 for axis in "xyz"])


def test_a_plan_of_a_log_is_on_the_screen_as_well(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = tmp_path / "next.toml"
    assert cli.run(["diagnose", written(tmp_path, at_rest(200)), *OPTIONS, "--plan", str(plan)]) == 0
    remarks = " ".join(line[2:] for line in plan.read_text().splitlines() if line.startswith("# "))
    where, _, text = capsys.readouterr().out.partition(f"{plan}: ")
    assert where
    assert remarks
    assert remarks in " ".join(text.split())


def test_of_gyroscopes_alone_nothing_is_reported_of_gravity_or_accelerometers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path, at_rest(200.0)[:, :3], "gx,gy,gz")
    assert cli.run(["diagnose", log, "--rate", str(RATE), "--gyro", "gx,gy,gz", "--unit-gyro", "deg/s"]) == 0
    reported = capsys.readouterr().out
    assert "gyroscope.scale_factor" in reported
    assert "Earth's rate" in reported
    for word in ("gravity", "accelerometer"):
        assert word not in reported


def test_whose_residuals_exceed_noise_is_reported(tmp_path: Path) -> None:
    table, out, rng = sequence()[0], tmp_path / "out.json", np.random.default_rng(5)
    for first in range(8 * RATE, len(table), 10 * RATE):  # every transfer at a scale factor of its own
        table[first : first + 2 * RATE, :3] *= 1 + 2e-3 * rng.standard_normal(3)
    assert cli.run(["diagnose", written(tmp_path, table), *OPTIONS, "--json", str(out)]) == 0
    [warning] = [text for text in json.loads(out.read_text())["solution"]["warnings"] if "exceed" in text]
    assert warning.startswith("residuals of the gyroscopes in the transfers exceed")
