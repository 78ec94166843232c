"""``station solve`` from folder to file: its exit codes, and the same answer from CSV and MCAP."""

import json
import shutil
from pathlib import Path

import pytest

from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.paths import DATA
from tests.station.campaign_writing import write_campaign


@pytest.fixture
def clean(tmp_path: Path) -> Path:
    data = DATA
    if not (data / "campaigns/clean").is_dir():
        pytest.skip(f"no shared data at {data}: set STATION_DATA")
    return Path(shutil.copytree(data / "campaigns/clean", tmp_path / "clean"))


def keep(folder: Path, *names: str) -> None:
    """Drop from a folder's campaign.toml every step whose file is not among ``names``."""
    head, *steps = (folder / "campaign.toml").read_text().split("\n[[")
    (folder / "campaign.toml").write_text("\n[[".join([head, *(s for s in steps if any(n in s for n in names))]))


def test_csv_and_mcap_give_the_same_solution(clean: Path, tmp_path: Path) -> None:
    twin = tmp_path / "twin"
    write_campaign(twin, read_campaign(clean).campaign, 0.02, ".mcap")
    solutions = []
    for folder in (clean, twin):
        out = tmp_path / f"{folder.name}.json"
        assert cli.run(["solve", str(folder), "--json", str(out)]) == 0
        solutions.append(json.loads(out.read_text()))
    csv, mcap = solutions
    assert set(csv["provenance"].pop("files")) >= {"campaign.toml", "turn_x_plus.csv"}
    mcap["provenance"].pop("files")
    for solution in solutions:
        solution["provenance"].pop("created_utc")
    assert csv["accelerometer"]["scale_factor"]["unit"] == "count/(g s)"
    assert csv == mcap


def test_dwells_without_turns_give_the_accelerometer_alone(clean: Path, tmp_path: Path) -> None:
    keep(clean, "dwell_")
    out = tmp_path / "out.json"
    assert cli.run(["solve", str(clean), "--json", str(out)]) == 0
    solution = json.loads(out.read_text())
    assert "accelerometer" in solution
    assert "gyroscope" not in solution
    assert any("gyroscope" in name for name in solution["not_observable"])
    assert any("gyroscope" in warning for warning in solution["warnings"])


def test_two_faces_alone_are_exit_5_and_what_is_missing_is_named(
    clean: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    keep(clean, "dwell_01", "dwell_02", "dwell_03", "dwell_04")
    assert cli.run(["solve", str(clean)]) == 5
    assert capsys.readouterr().err.count("\n") == 1


def test_a_wrong_position_is_exit_3_and_names_dwell_and_faces(
    clean: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (clean / "campaign.toml").read_text()
    (clean / "campaign.toml").write_text(text.replace("position = 4\n", "position = 5\n"))
    assert cli.run(["solve", str(clean), "--json", str(clean / "out.json")]) == 3
    error = capsys.readouterr().err
    assert "dwell_04_position_04.csv" in error
    assert "y_up" in error
    assert "x_down" in error
    assert not (clean / "out.json").exists()
