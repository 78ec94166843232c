"""The page on faults has a row for every case, and names tests that are there."""

import re

from tests.paths import ROOT
from tests.station.stream.live.test_triad_faults import CASES as TRIAD_CASES
from tests.station.stream.reader.faulty import CASES

PAGE = (ROOT / "docs/explanation/faults.md").read_text(encoding="utf-8")
ROWS = [[cell.strip() for cell in row.split("|")[1:-1]] for row in PAGE.splitlines() if row.startswith("| ")]


def test_every_test_named_is_there() -> None:
    tests = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    named = set(re.findall(r"`(test_\w+)`", PAGE))
    assert len(named) > 15
    for name in named:
        assert f"def {name}(" in tests, name


def test_every_case_has_its_row() -> None:
    cases = {name for row in ROWS for name in re.findall(r"E, `([^`]+)`", row[3])}
    assert cases == {case.name for case in CASES}


def test_every_case_of_a_triad_has_its_row() -> None:
    named = {name for row in ROWS if row[3].startswith("T, ") for name in re.findall(r"`([^`_]+)`", row[3])}
    assert named == {case.name for case in TRIAD_CASES}
