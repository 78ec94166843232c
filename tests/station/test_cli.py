"""Every command: quick help, the options that all share, exit codes with one line."""

import importlib
import inspect
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from procedures.errors import NotObservable, WrongFace
from station import cli, exit_codes
from station.commands import COMMANDS, Command, Database
from station.errors import Altered, CannotWrite, DataRefused
from station.exit_codes import EXIT_CODES


def leaves(table: tuple[Command, ...], path: tuple[str, ...] = ()) -> Iterator[Any]:
    """Yield every command that does something: the words that name it, and its function."""
    for command in table:
        module, words = importlib.import_module(command.module), (*path, command.name)
        if hasattr(module, "COMMANDS"):
            yield from leaves(module.COMMANDS, words)
        else:
            yield pytest.param(words, getattr(module, command.function), id="-".join(words))


@pytest.mark.parametrize(("words", "function"), leaves(COMMANDS))
def test_each_command_takes_db_and_shows_an_example(
    words: tuple[str, ...], function: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    assert inspect.signature(function).parameters["db"].annotation == Database
    assert cli.run([*words, "--help"]) == 0
    said = capsys.readouterr().out
    assert f"station {' '.join(words)}" in said.split("Example", 1)[1]
    assert "STATION_DB" in said


def test_help_lists_all_commands_at_once_and_imports_none() -> None:
    program = "import sys; from station.cli import run; run(['--help']); print(sorted(sys.modules))"
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    text, _, modules = said.rpartition("[")
    assert all(f"  {command.name} " in text and command.help[:30] in text for command in COMMANDS)
    assert not [name for name in ("numpy", "scipy", "pydantic", "rich", "mcap") if f"'{name}'" in modules]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "Missing command"),
        (["bake"], "No such command 'bake'"),
        (["solve"], "Missing argument"),
        (["solve", "--jason", "x", "y"], "No such option: --jason"),
    ],
)
def test_wrong_usage_is_exit_2_and_one_line(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(arguments) == 2
    error = capsys.readouterr().err
    assert said in error
    command = " ".join(["station", *arguments[:1]]) if arguments[:1] == ["solve"] else "station"
    assert error.endswith(f". Try `{command} --help`.\n")
    assert ".." not in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (DataRefused("a.csv", 3, "x", "y"), 3),
        (WrongFace("a.csv", 1, "x_up", "x_down"), 3),
        (NotObservable("k", ["position 3"]), 5),
        (Altered("a.csv", "x", "y"), 1),
        (CannotWrite("a.json", "full"), 2),
        (KeyboardInterrupt(), 130),
        (ZeroDivisionError("x"), exit_codes.BUG),
        (SystemExit(4), 4),
    ],
)
def test_each_error_has_its_exit_code(error: BaseException, code: int) -> None:
    assert exit_codes.explain(error)[0] == code


@pytest.mark.parametrize("name", EXIT_CODES)
def test_the_names_in_the_table_of_exit_codes_exist(name: str) -> None:
    module, _, kind = name.rpartition(".")
    assert issubclass(getattr(importlib.import_module(module), kind), BaseException)


def test_a_line_for_people_is_one_line() -> None:
    assert exit_codes.one_line("a\nb\x1b[31m\tc\u2028d") == "a b [31m c d"


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
