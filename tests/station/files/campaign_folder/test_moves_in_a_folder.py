"""``[[move]]`` and ``axes`` in a campaign's folder, from simulated counts to a solution."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.frames import ATTITUDES
from station.cli import app
from station.errors import DataRefused
from station.exit_codes import explain
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign

TRUTH = replace(Truth.example(31), temperature_rise_k=0.0)
ALL_FACES_TWICE = (1, 14, 4, 15, 6, 18, 19, 8, 10, 22, 23, 12)  # both kinds of attitudes, two on every face


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("carried") / "campaign"
    made = simulate_campaign(TRUTH, 5, dwell_s=12.0, positions=ALL_FACES_TWICE, turns=(), move_s=12.0, moves=True)
    write_campaign(path, made, TRUTH.sample_period_s)
    return path


def edited(folder: Path, tmp_path: Path, *changes: tuple[str, str]) -> Path:
    copy = tmp_path / "copy"
    copy.mkdir()
    for file in folder.iterdir():
        (copy / file.name).write_bytes(file.read_bytes())
    text = (copy / "campaign.toml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (copy / "campaign.toml").write_text(text)
    return copy


def test_moves_and_attitudes_are_read_as_they_were_recorded(folder: Path) -> None:
    read = read_campaign(folder).campaign
    assert [dwell.position for dwell in read.dwells] == list(ALL_FACES_TWICE)
    assert f'axes = "{ATTITUDES[13]}"' in (folder / "campaign.toml").read_text()
    assert [(m.name, m.before, m.after) for m in read.moves[:2]] == [
        ("move_01.csv", "dwell_01.csv", "dwell_14.csv"),
        ("move_02.csv", "dwell_14.csv", "dwell_04.csv"),
    ]
    assert read.moves[0].series.t[0] - read.dwells[0].series.t[-1] == pytest.approx(0.02)
    assert read.sigma.seat == pytest.approx(np.pi / 180 / 3600)


def test_the_command_solves_gyroscopes_that_no_turn_was_made_with(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "solution.json"
    done = CliRunner().invoke(app, ["solve", str(folder), "--json", str(out)])
    assert done.exit_code == 0, done.output
    found = json.loads(out.read_text())
    gyro = found["gyroscope"]["scale_factor"]
    assert np.abs(np.array(gyro["value"]) / TRUTH.gyro_k - 1).max() < 5e-5
    assert np.abs((np.array(gyro["value"]) - TRUTH.gyro_k) / np.array(gyro["std"])).max() < 4
    without = CliRunner().invoke(app, ["solve", str(folder), "--no-moves", "--json", str(out)])
    assert without.exit_code == 0
    assert json.loads(out.read_text()).get("gyroscope") is None


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('from = "dwell_01.csv"', 'from = "dwell_02.csv"'), ('to = "dwell_14.csv"', 'to = "move_01.csv"'),
        ('to = "dwell_14.csv"', 'to = "dwell_04.csv"'), (f'axes = "{ATTITUDES[13]}"', 'axes = "SDD"'),
        (f'axes = "{ATTITUDES[13]}"', f'axes = "{ATTITUDES[13]}"\nposition = 3'),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(folder: Path, tmp_path: Path, old: str, new: str) -> None:
    with refused(DataRefused):
        read_campaign(edited(folder, tmp_path, (old, new)))


def test_a_wrong_label_is_said_as_that(folder: Path, tmp_path: Path) -> None:
    wrong = edited(folder, tmp_path, (f'axes = "{ATTITUDES[14]}"', f'axes = "{ATTITUDES[15]}"'))
    out = tmp_path / "solution.json"
    done = CliRunner().invoke(app, ["solve", str(wrong), "--json", str(out)])
    assert not out.exists()
    assert done.exception is not None
    code, line = explain(done.exception)
    assert code == 3
    assert "dwell_15.csv" in line
