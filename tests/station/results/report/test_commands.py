from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import typer
from typer.testing import CliRunner, Result

from station.commands.report import report
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis import closed_loop
from tests.station.results.report import factory

CAMPAIGN = """format = "campaign/1"
[imu]
model = "FOG-3"
serial = "S0101"
sample_period_s = 0.02
output = "increments"
[site]
latitude_deg = 31.17
[[dwell]]
position = 1
file = "dwell_01.csv"
[[soak]]
position = 1
file = "soak.csv"
"""


CONSISTENT = {
    "format": "diagnosis/1", "verdict": "consistent", "log10_p": -0.3, "findings": [], "error": [],
    "parameters": [], "tried": [], "next_measurement": "",
}  # fmt: skip


def closed(loaded: Sequence[LoadedCampaign]) -> SimpleNamespace:
    fits = SimpleNamespace(campaigns=tuple(one.campaign for one in loaded))
    return SimpleNamespace(
        solution=factory.solution(),
        fits=fits,
        document=CONSISTENT,
        diagnosis=None,
        budgets=factory.budgets,
        effects=(),
    )


def _run(command: Callable[..., Any], *arguments: str | Path) -> Result:
    app = typer.Typer()
    app.command()(command)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def _rows(start: float) -> str:
    lines = [f"{start + 0.02 * i:.2f},1,2,{i % 2},20,{i % 3},0,23.0" for i in range(1, 101)]
    return "\n".join(["t_s,gx,gy,gz,ax,ay,az,temp_c", *lines, ""])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder whose solve is made up: here only the way from folder to file is looked at."""
    monkeypatch.setattr(closed_loop, "close_loop", closed)
    (tmp_path / "campaign.toml").write_text(CAMPAIGN)
    (tmp_path / "dwell_01.csv").write_text(_rows(0.0))
    (tmp_path / "soak.csv").write_text(_rows(10.0))
    return tmp_path


def test_report_writes_one_file_with_the_folder_s_hashes_and_unused_steps(folder: Path) -> None:
    out = folder / "out.html"
    result = _run(report, folder, "--out", out)
    assert result.exit_code == 0, result.output
    text = out.read_text()
    assert "S0101" in text
    assert "soak" in text
    assert "dwell_01.csv" in text
    assert "NO LIMITS" in text
    assert "What the model lacks" in text


def test_report_without_out_stands_in_the_folder(folder: Path) -> None:
    assert _run(report, folder).exit_code == 0
    assert (folder / "report.html").exists()
