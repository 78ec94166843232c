"""``station locate``: what it writes, what it says, and how it ends."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from station import cli
from tests.station.files.fusion_folder.drive_folders import write_folder, write_rows

OFF = np.array([0.0, 20.0, 20.0, 0.0, 0.0, 0.0, 0.0])


def run(folder: Path, tmp_path: Path, *options: str) -> int:
    """Run the command with all its outputs in ``tmp_path``."""
    outputs = (
        "--out",
        str(tmp_path / "t.tum"),
        "--batch",
        str(tmp_path / "b.tum"),
        "--json",
        str(tmp_path / "j.json"),
    )
    return cli.run(["locate", str(folder), *outputs, *options])


def test_a_recorded_odometry_is_located(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_folder(tmp_path / "log", seconds=30.0)
    assert run(folder, tmp_path, "--source", "odometry") == 0
    assert capsys.readouterr().out == ""
    reported = json.loads((tmp_path / "j.json").read_text())
    assert reported["format"] == "location/1"
    assert reported["error_m"]["online"]["mean"] < 0.15
    assert reported["error_m"]["batch"]["mean"] < reported["error_m"]["online"]["mean"]
    assert abs(reported["alignment"]["yaw_deg"] + np.degrees(1.0)) < 3 * reported["alignment"]["std"]["yaw_deg"]
    assert reported["rejected_fixes"] == 0
    assert reported["solve_ms"]["mean"] <= reported["solve_ms"]["worst"]
    online, smoothed = (np.loadtxt(tmp_path / name) for name in ("t.tum", "b.tum"))
    assert online[0, 0] == pytest.approx(reported["initialised_at_s"], abs=1e-6)
    assert np.diff(online[:, 0]).max() < 0.1001
    assert len(smoothed) == 300
    assert np.allclose(np.linalg.norm(online[:, 4:], axis=1), 1, atol=1e-6)


@pytest.mark.parametrize(
    ("option", "name"), [("--out", "fusion.toml"), ("--batch", "gnss.csv"), ("--json", "odometry.tum")]
)
def test_a_file_of_the_folder_is_never_written_over(
    tmp_path: Path, option: str, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_folder(tmp_path / "log", seconds=5.0)
    before = (folder / name).read_bytes()
    assert cli.run(["locate", str(folder), "--source", "odometry", option, str(folder / name)]) == 2
    assert "it is read here" in capsys.readouterr().err
    assert (folder / name).read_bytes() == before


def test_what_never_moves_is_exit_5_and_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_folder(tmp_path / "log")
    for name in ("odometry.tum", "truth.tum"):
        rows = np.loadtxt(folder / name)
        rows[:, 1:4] = rows[0, 1:4]
        np.savetxt(folder / name, rows, "%.9f")
    rows = np.loadtxt(folder / "gnss.csv", delimiter=",", skiprows=1)
    rows[:, 1:] = np.random.default_rng(1).normal(0, [0.2] * 3 + [0.05] * 3, (len(rows), 6))
    np.savetxt(folder / "gnss.csv", rows, "%.9f", ",", header="t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,vu_m_s", comments="")
    assert run(folder, tmp_path, "--source", "odometry") == 5
    assert "it must move further" in capsys.readouterr().err
    reported = json.loads((tmp_path / "j.json").read_text())
    assert "it must move further" in reported["why_not"]
    assert "initialised_at_s" not in reported
    assert not (tmp_path / "t.tum").exists()


def _rows(folder: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    rows = change(np.loadtxt(folder / "gnss.csv", delimiter=",", skiprows=1))
    write_rows(folder / "gnss.csv", ",", rows, "t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,vu_m_s")


def test_outliers_are_counted_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_folder(tmp_path / "log", seconds=30.0)
    _rows(folder, lambda rows: rows + (np.arange(300) % 10 == 9)[:, None] * OFF)
    assert cli.run(["locate", str(folder), "--source", "odometry"]) == 0
    reported = capsys.readouterr().out
    assert "rejected fixes        30 of 300" in reported
    assert "stand off" not in reported


def test_a_source_that_is_not_in_the_folder_is_exit_3(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_folder(tmp_path / "log")
    text = (folder / "fusion.toml").read_text()
    (folder / "fusion.toml").write_text(text.replace('[odometry]\nfile = "odometry.tum"\n', ""))
    assert run(folder, tmp_path, "--source", "odometry") == 3
    assert "found no [odometry]" in capsys.readouterr().err
