"""The program as a process: a quick help, a reader that leaves, Ctrl-C, its version."""

import subprocess
import sys

import pytest

from station import cli
from station.commands.command_table import COMMANDS


def test_help_lists_all_commands_at_once_and_imports_none() -> None:
    program = "import sys; from station.cli import run; run(['--help']); print(sorted(sys.modules))"
    reported = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    text, _, modules = reported.rpartition("[")
    assert all(f"  {command.name} " in text and command.help[:30] in text for command in COMMANDS)
    assert not [name for name in ("numpy", "scipy", "pydantic", "rich", "mcap") if f"'{name}'" in modules]


def test_a_reader_that_leaves_is_no_failure() -> None:
    program = "from station.cli import run; raise SystemExit(run(['devices', '--watch', '--seconds', '0.1']))"
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as station:
        assert station.stdout is not None and station.stderr is not None  # noqa: PT018
        station.stdout.readline()
        station.stdout.close()
        assert (station.wait(), station.stderr.read()) == (0, b"")


def test_ctrl_c_is_130_and_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(path: object, **_: object) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr("station.files.campaign_folder.campaign_reading.read_for_solve", interrupted)
    assert cli.run(["solve", "x"]) == 130
    assert capsys.readouterr().err == "cancelled\n"


def test_the_version_is_reported() -> None:
    command = [sys.executable, "-P", "-c", "from station.cli import main; main()", "--version"]
    reported = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert reported.startswith("station 1.")
    assert reported.count("\n") == 1
