"""Every refusal has a stable code and an exit code, which `--verbose` prints and a page lists."""

import importlib
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
import typer

from drivers.errors import BadDeviceUrl, DriverError
from fixtures_db.errors import DatabaseError
from procedures.errors import ErrorCode, NotObservable, ProcedureError, WrongFace
from station.cli import run
from station.errors import (
    BUG,
    EXIT_CODES,
    Altered,
    CannotWrite,
    DataRefused,
    StationError,
    error_code,
    exit_code,
    explain,
    one_line,
)
from tests.paths import ROOT

FAMILIES = (StationError, DriverError, ProcedureError, DatabaseError)  # each the base of what a layer raises


@cache
def sources() -> dict[str, str]:
    """Return the text of every module of the program by its name."""
    files = [file for package in ("station", "drivers", "procedures", "fixtures_db")
             for file in (ROOT / package).rglob("*.py")]  # fmt: skip
    return {
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file.read_text("utf-8")
        for file in files
    }


def refusals() -> Iterator[type[Exception]]:
    """Yield every class that the program raises on purpose: all that come of one of the families."""
    names = {kind.__name__ for kind in FAMILIES}
    classes = [
        (module, name, set(re.findall(r"\w+", bases)))
        for module, text in sources().items()
        for name, bases in re.findall(r"^class (\w+)\((.*)\):", text, re.MULTILINE)
    ]
    while more := {name for _, name, bases in classes if bases & names} - names:
        names |= more
    for module, name, bases in classes:
        if bases & names and issubclass(kind := getattr(importlib.import_module(module), name), FAMILIES):
            yield kind


def test_every_class_of_refusal_has_a_code_and_an_exit_code() -> None:
    found = set(refusals())
    assert len(found) > 50
    for kind in found:
        error = kind.__new__(kind)
        assert isinstance(kind.code, ErrorCode), kind
        assert error_code(error) is kind.code, kind
        assert (exit_code(error) is None) == (kind.code is ErrorCode.BUG), kind


def test_every_code_and_every_exit_code_is_of_something_that_there_is() -> None:
    source = "".join(sources().values())
    assert [code.name for code in ErrorCode if f"ErrorCode.{code.name}" not in source] == []
    for name in EXIT_CODES:
        module, _, kind = name.rpartition(".")
        assert issubclass(getattr(importlib.import_module(module), kind), BaseException)


@pytest.mark.parametrize(
    ("error", "stable", "code"),
    [
        (DataRefused("a.csv", 3, "x", "y", code=ErrorCode.TIME_UNIT), ErrorCode.TIME_UNIT, 3),
        (DataRefused("a.csv", 3, "x", "y"), ErrorCode.DATA, 3),
        (WrongFace("a.csv", 1, "x_up", "x_down"), ErrorCode.PROCEDURE, 3),
        (NotObservable("bias", ("rests",)), ErrorCode.NOT_OBSERVABLE, 5),
        (Altered("a.csv", "x", "y"), ErrorCode.ALTERED, 1),
        (CannotWrite("a.json", "full"), ErrorCode.CANNOT_WRITE, 2),
        (BadDeviceUrl("x", "y", "z"), ErrorCode.DEVICE_ADDRESS, 2),
        (typer.BadParameter("x"), ErrorCode.USAGE, 2),
        (KeyboardInterrupt(), ErrorCode.CANCELLED, 130),
        (SystemExit(4), ErrorCode.USAGE, 4),
        (ZeroDivisionError(), ErrorCode.BUG, BUG),
    ],
)
def test_the_codes_of_an_error(error: BaseException, stable: ErrorCode, code: int) -> None:
    assert error_code(error) is stable
    assert explain(error)[0] == code


def test_a_refusal_is_one_printable_line() -> None:
    assert one_line("a\nb\x1b[31m\tc\u2028d") == "a b [31m c d"


def test_verbose_prints_the_code_wherever_it_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = str(tmp_path / "no_such.csv")
    for arguments in (["--verbose", "noise", missing], ["noise", missing, "--verbose"]):
        assert run(arguments) == 3
        assert f"[{ErrorCode.FILE_MISSING}: {ErrorCode.FILE_MISSING.meaning}]" in capsys.readouterr().err
    assert run(["noise", missing]) == 3
    assert "[E-" not in capsys.readouterr().err
