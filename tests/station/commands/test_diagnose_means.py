"""A table of means as people have it in a spreadsheet, from the file to the printed calibration."""

import json
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station import cli
from station.errors import DataRefused
from station.files.logs.log_columns import ColumnOptions
from station.files.logs.means_table import means_of
from station.files.tables.reader import read_table
from tests.procedures.free_positions.test_pose_means import BIAS, SIX, K, directions, outputs
from tests.refusals import refused

G = 9.80665


def table(
    path: Path, u: np.ndarray, names: str = "mean_a{}", more: str = "", std: str = "", delimiter: str = ","
) -> Path:
    write(path, G * outputs(u, 5), names, more, std, delimiter)
    return path


def write(path: Path, accel: np.ndarray, names: str, more: str, std: str, delimiter: str = ",") -> None:
    header = ["pose", *(names.format(axis) for axis in "xyz")]
    header += [std.format(axis) for axis in "xyz"] if std else []
    rows = [header + ([more] if more else [])]
    for i, row in enumerate(accel):
        cells = [str(i + 1), *(f"{value:.5f}" for value in row), *(["0.02"] * 3 if std else [])]
        rows.append(cells + (["100"] if more else []))
    path.write_text("\n".join(map(delimiter.join, rows)) + "\n")


def run(*arguments: str, out: Path) -> dict[str, object]:
    assert cli.run(["diagnose", *arguments, "--json", str(out)]) == 0
    found: dict[str, object] = json.loads(out.read_text())
    return found


@pytest.mark.parametrize(
    ("names", "std", "more", "delimiter"),
    [
        ("mean_a{}", "", "", ","),
        ("Acc_{} [m/s^2]", "Acc_{}_std [m/s^2]", "count", ";"),
        ("a{}", "sigma_a{}", "samples", "\t"),
    ],
)
def test_a_table_is_known_by_itself_and_calibrates(
    names: str, std: str, more: str, delimiter: str, tmp_path: Path
) -> None:
    file = table(tmp_path / "poses.csv", directions(16, 2), names, more, std, delimiter)
    document = run(str(file), "--latitude", "48", out=tmp_path / "m.json")
    accelerometer = document["accelerometer"]
    assert isinstance(accelerometer, dict)
    k, bias = accelerometer["scale_factor"], accelerometer["bias"]
    planted = np.linalg.norm(K, axis=1)
    assert np.all(np.abs(np.array(k["value"]) - planted * G / 9.80936) < 4 * np.array(k["std"]) + 1e-3)
    assert np.all(np.abs(np.array(bias["value"]) - 1e3 * BIAS / planted) < 4 * np.array(bias["std"]) + 0.1)
    assert accelerometer["held_out_rms_mg"] > accelerometer["residual_rms_mg"] > 0
    assert document["poses"] == 16


def test_six_rows_say_what_they_do_not_show(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = table(tmp_path / "six.csv", SIX, more="n", std="std_a{}")
    assert cli.run(["diagnose", str(file), "--as", "means"]) == 0
    reported = capsys.readouterr().out
    assert reported.startswith("SOLVED, BUT NOT CHECKED.")
    assert reported.count("accelerometer.misalignment") == 3
    assert "held out" not in reported


STD = 0.02 / np.sqrt(100)  # m/s2, of the means that `write` states


def noisy(scatter: float = STD) -> np.ndarray:
    """Return means [m/s2] of 18 poses that scatter by so much."""
    return G * outputs(directions(18, 2), 2, scatter / G)


def stated(path: Path, accel: np.ndarray) -> str:
    write(path, accel, "a{}", "n", "sd_a{}")
    return str(path)


def test_poses_within_their_noise_are_consistent(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = stated(tmp_path / "poses.csv", noisy())
    document = run(file, out=tmp_path / "m.json")
    assert (document["verdict"], document["wrong_poses"]) == ("consistent", [])
    assert -2 < document["log10_p"] < 0  # type: ignore[operator]
    capsys.readouterr()
    assert cli.run(["diagnose", file]) == 0
    assert capsys.readouterr().out.startswith("CONSISTENT. No pose contradicts the others.")


@pytest.mark.parametrize("off", [0.9, 30.0])  # m/s2
def test_a_wrong_digit_is_found_and_the_values_are_without_it(
    off: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    accel = noisy()
    right = run(stated(tmp_path / "right.csv", accel), out=tmp_path / "r.json")
    accel[6, 2] += off
    page = tmp_path / "page.html"
    wrong = run(file := stated(tmp_path / "wrong.csv", accel), "--html", str(page), out=tmp_path / "w.json")
    (pose,) = wrong["wrong_poses"]  # type: ignore[misc]
    assert (wrong["verdict"], pose["pose"], pose["line"], pose["is_held_out"]) == ("established", 7, 8, True)
    assert pose["sigmas"] > 100
    for key in ("scale_factor", "bias"):
        a, b = (each["accelerometer"][key] for each in (right, wrong))  # type: ignore[index]
        assert np.all(np.abs(np.subtract(a["value"], b["value"])) < 3 * np.array(b["std"]))
    assert "Pose 7 (line 8) contradicts the 17 others" in page.read_text()
    capsys.readouterr()
    assert cli.run(["diagnose", file]) == 0
    assert capsys.readouterr().out.startswith("ESTABLISHED. Pose 7 (line 8)")


def test_scatter_beyond_the_stated_noise_is_unexplained(tmp_path: Path) -> None:
    document = run(stated(tmp_path / "poses.csv", noisy(10 * STD)), out=tmp_path / "m.json")
    assert (document["verdict"], document["wrong_poses"]) == ("unexplained", [])
    part = document["accelerometer"]
    assert isinstance(part, dict)
    assert np.sqrt(part["chi2"] / part["degrees_of_freedom"]) == pytest.approx(10, rel=0.5)


def test_too_few_poses_have_an_exit_code_of_their_own(tmp_path: Path) -> None:
    assert cli.run(["diagnose", stated(tmp_path / "poses.csv", noisy()[:5]), "--as", "means"]) == 5


@pytest.mark.parametrize("option", [["--discover"], ["--plan", "next.toml"], ["--validate", "other.csv"]])
def test_an_option_that_a_table_of_means_does_not_use_is_refused(option: list[str], tmp_path: Path) -> None:
    assert cli.run(["diagnose", stated(tmp_path / "poses.csv", noisy()), *option]) == 2


@pytest.mark.parametrize(("column", "cell"), [("n", "0"), ("std_ay", ""), ("std_ay", "-0.1")])
def test_a_cell_of_a_count_or_a_standard_deviation_is_refused_by_its_line(
    column: str, cell: str, tmp_path: Path
) -> None:
    file = table(tmp_path / "poses.csv", directions(16, 2), more="n", std="std_a{}")
    head, *rows = (line.split(",") for line in file.read_text().splitlines())
    rows[4][head.index(column)] = cell
    file.write_text("\n".join(map(",".join, [head, *rows])))
    with refused(DataRefused, ErrorCode.COLUMNS, column, line=6):
        means_of(read_table(file), ColumnOptions())


def test_gyroscopes_at_rest_give_a_bias_alone(tmp_path: Path) -> None:
    accel = outputs(directions(16, 2), 5)
    gyro = [0.01, -0.02, 0.03] + 1e-4 * np.random.default_rng(1).normal(size=(16, 3))
    rows = ["ax [g],ay [g],az [g],gx [deg/s],gy [deg/s],gz [deg/s]"]
    rows += [",".join(f"{cell:.6f}" for cell in (*a, *g)) for a, g in zip(accel, gyro, strict=True)]
    (tmp_path / "poses.csv").write_text("\n".join(rows))
    document = run(str(tmp_path / "poses.csv"), out=tmp_path / "m.json")
    gyroscope = document["gyroscope"]
    assert isinstance(gyroscope, dict)
    assert gyroscope["bias"]["value"] == pytest.approx([0.01, -0.02, 0.03], abs=3e-4)
    assert gyroscope["bias"]["unit"] == "deg/s"
    assert "gyroscope.scale_factor" in document["not_observable"]  # type: ignore[operator]
