"""What the library promises: its names and signatures, and that what the pages show is what it does."""

import dataclasses
import doctest
import inspect
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from station import calibration
from tests.paths import ROOT

PROMISED = {
    "load": "(path)",
    "calibration_of": "(document, where='calibration')",
    "Calibration.apply": "(self, counts, t, temperature=None, auxiliary=None, frame='sensor', output='counts', *, "
    "magnetic=None, period=None, axes=None, force=False)",
    "Calibration.stream": "(self, period, *, frame='sensor', output='counts', axes=None, force=False)",
    "Calibration.without": "(self, *names)",
    "CalibrationStream.apply": "(self, counts, t, temperature=None, auxiliary=None, *, magnetic=None, last=False)",
}
FIELDS = {
    "Calibration": ("model", "serial", "output", "effects", "document"),
    "Calibrated": (
        "t", "specific_force", "angular_rate", "spans", "specific_force_std", "angular_rate_std", "warnings",
    ),
}  # fmt: skip
NAMES = {"Calibrated", "Calibration", "CalibrationStream", "DataRefused", "calibration_of", "load"}
PAGES = ("README.md", "docs/reference/library.md")


def _bare(function: Any) -> str:
    found = inspect.signature(function)
    plain = [each.replace(annotation=inspect.Parameter.empty) for each in found.parameters.values()]
    return str(found.replace(parameters=plain, return_annotation=inspect.Signature.empty))


def _named(path: str) -> Any:
    found: Any = calibration
    for part in path.split("."):
        found = getattr(found, part)
    return found


def test_its_names_are_those_that_are_promised() -> None:
    assert set(calibration.__all__) == NAMES
    page = (ROOT / "docs/reference/library.md").read_text(encoding="utf-8")
    assert all(f"`{name}" in page for name in NAMES)


@pytest.mark.parametrize("name", PROMISED)
def test_a_signature_is_as_promised(name: str) -> None:
    assert _bare(_named(name)) == PROMISED[name]


@pytest.mark.parametrize("name", FIELDS)
def test_fields_are_as_promised(name: str) -> None:
    assert tuple(field.name for field in dataclasses.fields(_named(name))) == FIELDS[name]


def test_public_methods_are_all_promised() -> None:
    for kind in ("Calibration", "CalibrationStream", "Calibrated"):
        own = {name for name, value in vars(_named(kind)).items() if name[0] != "_" and inspect.isfunction(value)}
        assert {f"{kind}.{name}" for name in own} <= set(PROMISED)


@contextmanager
def _in_root() -> Iterator[None]:
    before = os.getcwd()
    os.chdir(ROOT)
    try:
        yield
    finally:
        os.chdir(before)


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_shows_is_what_comes_out(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = [block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if ">>>" in block]
    assert blocks, "no example"
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    with _in_root():
        for block in blocks:
            runner.run(parser.get_doctest(block, {}, page, page, 0))
    assert runner.failures == 0
