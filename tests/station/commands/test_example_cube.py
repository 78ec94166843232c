"""The cube of the paper is in every new database."""

from pathlib import Path

import pytest

from station import cli


def test_the_example_cube_is_listed_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    where = ["--db", str(tmp_path / "station.db")]
    assert cli.run(["fixtures", "list", "cube", *where]) == 0
    assert "P1" in capsys.readouterr().out
    assert cli.run(["fixtures", "show", "cube", "P1", *where]) == 0
    assert "t4-1" in capsys.readouterr().out
    assert cli.run(["fixtures", "show", "cube", "X", *where]) == 3
    assert "no cube 'X'" in capsys.readouterr().err
