"""`station certificate --example` prints a file that the command itself reads."""

from pathlib import Path

import pytest

from station.cli import run
from station.results.certificate.laboratory import read_laboratory


def test_the_sample_is_a_laboratory_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["certificate", "--example"]) == 0
    sample = tmp_path / "lab.toml"
    sample.write_text(capsys.readouterr().out, encoding="utf-8")
    assert read_laboratory(sample).laboratory.name == "Inertial Laboratory, Example Institute"


def test_without_a_laboratory_the_sample_is_offered(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["certificate", "SIM-7"]) == 2
    assert "certificate --example" in capsys.readouterr().err
