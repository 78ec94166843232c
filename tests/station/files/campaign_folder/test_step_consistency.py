"""Resets of the device's clock in a campaign are one counted remark; an overlap that none explains is refused."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from typer.testing import CliRunner

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.counts.sample_records import RateSeries
from procedures.counts.sample_times import SampleTimes
from procedures.positions import ATTITUDES
from station.cli import app
from station.errors import DataRefused, explain
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import StepTable
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.campaign_folder.sample_series import StepData
from station.files.campaign_folder.step_consistency import refuse_overlap, with_one_period
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign


def timed_step(name: str, begin: float, host: float | None, turn_on: int = 1) -> Any:
    span = None if host is None else (host, host + 10.0)
    data = SimpleNamespace(span=(begin, begin + 10.0), host_span=span)
    return SimpleNamespace(table=SimpleNamespace(file=name, turn_on=turn_on), data=data)


def test_any_number_of_resets_is_one_remark() -> None:
    steps = [timed_step(f"move_{i}.mcap", 5.0 * i, 100.0 * i) for i in range(5)]
    remarks = refuse_overlap(Path("campaign"), steps)
    assert len(remarks) == 1
    assert "4 steps" in remarks[0]
    assert all(f"move_{i}.mcap" in remarks[0] for i in range(1, 5))


def test_steps_apart_leave_no_remark() -> None:
    assert refuse_overlap(Path("campaign"), [timed_step("a", 0.0, None), timed_step("b", 20.0, None)]) == []
    assert refuse_overlap(Path("campaign"), [timed_step("a", 0.0, None, 1), timed_step("b", 5.0, None, 2)]) == []


def test_an_overlap_that_nothing_explains_is_refused() -> None:
    with pytest.raises(DataRefused):
        refuse_overlap(Path("campaign"), [timed_step("a", 0.0, None), timed_step("b", 5.0, None)])


T = 5.0 + 0.01 * np.arange(101)


def step(period: float, std: float, is_uneven: bool = True) -> LoadedStep:
    series = RateSeries(T, None, np.zeros((101, 3)), np.full(101, np.nan), period)
    times = SampleTimes(T, period, np.zeros(1, np.int64), is_uneven, std)
    return LoadedStep("position", cast(StepTable, None), StepData(series, (5.0, 6.0), times))


def test_periods_that_agree_are_averaged_by_their_sigmas() -> None:
    steps = [step(0.01 + 1e-7, 1e-7), step(0.01 - 1e-7, 2e-7), step(0.0099, 1.0, is_uneven=False)]
    found, std, reported = with_one_period(steps)
    mean = 0.01 + (1e-7 * 4 - 1e-7) / 5
    assert [each.data.series.period for each in found if each.data] == pytest.approx(
        [mean, mean, 0.0099], rel=1e-12
    )
    weights = 1e14 + 0.25e14
    spread = (1e14 * (1e-7 - (mean - 0.01)) ** 2 + 0.25e14 * (1e-7 + (mean - 0.01)) ** 2) / 1
    assert spread < 1.0
    assert std == pytest.approx(1 / np.sqrt(weights) / mean)
    assert f"{mean:.9g} s +- {1e6 * std:.2g} ppm" in reported[0]
    series = found[0].data.series if found[0].data else None
    assert series is not None
    np.testing.assert_allclose(series.t, 5.5 + (T - 5.5) * mean / (0.01 + 1e-7), rtol=1e-12)
    assert found[2] is steps[2]


def test_files_that_differ_by_more_than_their_sigmas_widen_it() -> None:
    offs = np.array([-3e-7, 0.0, 3e-7])
    _, std, _ = with_one_period([step(0.01 + off, 1e-7) for off in offs])
    assert std == pytest.approx(np.sqrt(18 / 2 / 3) * 1e-7 / 0.01, rel=1e-4)


@pytest.mark.parametrize(
    ("off", "std", "is_near"),
    [
        (0.9e-5, 1e-7, True),
        (1.1e-5, 1e-7, False),
        (3.9e-5, 1e-5, True),
        (4.1e-5, 1e-5, False),
    ],
)
def test_a_file_of_quite_another_period_keeps_its_own(off: float, std: float, is_near: bool) -> None:
    for other in (0.01 + off, 0.01 - off):
        steps = [step(0.01, 1e-7), step(0.01, 1e-7), step(other, std)]
        found, _, _ = with_one_period(steps)
        assert (found[2] is not steps[2]) == is_near


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


def test_a_wrong_label_is_reported_as_that(folder: Path, tmp_path: Path) -> None:
    wrong = edited(folder, tmp_path, (f'axes = "{ATTITUDES[14]}"', f'axes = "{ATTITUDES[15]}"'))
    out = tmp_path / "solution.json"
    done = CliRunner().invoke(app, ["solve", str(wrong), "--json", str(out)])
    assert not out.exists()
    assert done.exception is not None
    code, line = explain(done.exception)
    assert code == 3
    assert "dwell_15.csv" in line
