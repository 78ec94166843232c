"""The wording of the program, one readable file for each command: its help, and what it says of its main refusals.

No other test holds an English sentence. After a change of words: ``pytest tests/station/commands/test_wording.py
--snapshot-update``, and read the difference.
"""

import importlib
import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

from station import cli
from station.commands import Database
from station.commands.command_table import COMMANDS, Command
from station.results.certificate.laboratory import read_laboratory
from tests.station.commands.refusal_lines import LINES
from tests.station.commands.transcripts import TextFile, transcript


def leaves(command: Command, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the words of every command that does something, each of which takes ``--db``."""
    module, words = importlib.import_module(command.module), (*path, command.name)
    if hasattr(module, command.function):
        assert inspect.signature(getattr(module, command.function)).parameters["db"].annotation == Database
        yield words
        return
    for each in module.COMMANDS:
        yield from leaves(each, words)


@pytest.fixture(autouse=True)
def _empty_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("STATION_DB", "station.db")


def test_the_wording_of_the_program_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
) -> None:
    lines = ["--help", "", "bake", "solve --jason x y"]
    assert transcript(lines, tmp_path, capsys) == snapshot.use_extension(TextFile)


@pytest.mark.parametrize("command", COMMANDS, ids=[command.name for command in COMMANDS])
def test_the_wording_of(
    command: Command, tmp_path: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
) -> None:
    words = [" ".join(each) for each in leaves(command)]
    helps = transcript([f"{each} --help" for each in words], tmp_path, capsys)
    for each in words:
        assert f"station {each}" in helps.partition(f"$ station {each} --help")[2].partition("Example")[2], each
    reported = transcript(LINES.get(command.name, ()), tmp_path, capsys)
    assert f"{helps}\n{reported}" == snapshot.use_extension(TextFile)


@pytest.mark.parametrize(("asked", "read"), [("certificate", "laboratory"), ("fixtures limits M", "limits")])
def test_the_sample_that_is_printed_is_a_file_that_is_read(
    asked: str, read: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run([*asked.split(), "--example"]) == 0
    sample = tmp_path / "sample.toml"
    sample.write_text(capsys.readouterr().out, encoding="utf-8")
    if read == "laboratory":
        assert read_laboratory(sample).laboratory.name == "Inertial Laboratory, Example Institute"
    else:
        assert cli.run([*asked.split(), "--import", str(sample)]) == 0
