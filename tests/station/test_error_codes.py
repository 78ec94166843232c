"""Every refusal has a stable code, which `--verbose` prints and docs/error-codes.md lists."""

import importlib
from pathlib import Path

import pytest
import typer

import drivers
import fixtures_db
import procedures
import station
from drivers.errors import BadDeviceUrl
from procedures.error_codes import ErrorCode
from procedures.errors import NotObservable
from station.cli import run
from station.errors import DataRefused
from station.exit_codes import EXIT_CODES, error_code, exit_code
from tests.paths import ROOT


def test_every_family_of_refusals_has_a_code() -> None:
    for name in EXIT_CODES:
        module, _, kind = name.rpartition(".")
        assert isinstance(getattr(importlib.import_module(module), kind).code, ErrorCode), name


def test_every_code_is_used() -> None:
    files = [ROOT / package.__name__ for package in (station, drivers, procedures, fixtures_db)]
    source = "".join(file.read_text(encoding="utf-8") for folder in files for file in folder.rglob("*.py"))
    assert [code.name for code in ErrorCode if f"ErrorCode.{code.name}" not in source] == []


def test_the_page_lists_each_code_with_its_meaning() -> None:
    page = (ROOT / "docs/error-codes.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `E-")]
    assert rows == [f"| `{code}` | {code.meaning} |" for code in ErrorCode]


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (DataRefused("a.csv", 3, "x", "y", code=ErrorCode.TIME_UNIT), ErrorCode.TIME_UNIT),
        (DataRefused("a.csv", 3, "x", "y"), ErrorCode.DATA),
        (NotObservable("bias", ("rests",)), ErrorCode.NOT_OBSERVABLE),
        (BadDeviceUrl("x", "y", "z"), ErrorCode.DEVICE_ADDRESS),
        (typer.BadParameter("x"), ErrorCode.USAGE),
        (KeyboardInterrupt(), ErrorCode.CANCELLED),
        (ZeroDivisionError(), ErrorCode.BUG),
    ],
)
def test_the_code_of_an_error(error: BaseException, code: ErrorCode) -> None:
    assert error_code(error) is code
    assert (exit_code(error) is None) == (code in {ErrorCode.USAGE, ErrorCode.CANCELLED, ErrorCode.BUG})


def test_verbose_prints_it_wherever_it_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = str(tmp_path / "no_such.csv")
    for arguments in (["--verbose", "noise", missing], ["noise", missing, "--verbose"]):
        assert run(arguments) != 0
        assert "[E-" in capsys.readouterr().err
    assert run(["noise", missing]) != 0
    assert "[E-" not in capsys.readouterr().err
