"""The page on faults says what the code says, and names tests that are there."""

import re

import pytest

from tests.paths import ROOT
from tests.station.stream.live.test_triad_faults import CASES as TRIAD_CASES
from tests.station.stream.reader.faulty import CASES

PAGE = (ROOT / "docs/faults.md").read_text(encoding="utf-8")
ROWS = [[cell.strip() for cell in row.split("|")[1:-1]] for row in PAGE.splitlines() if row.startswith("| ")]
SEEN = [words for row in ROWS for words in re.findall(r"`([^`]+)`", row[1])]


def _joined(folders: list[str]) -> str:
    """Return sources with their string literals run together, as they are at run time, numbers as #."""
    texts = "".join(path.read_text(encoding="utf-8") for each in folders for path in (ROOT / each).rglob("*.py"))
    return re.sub(r'"\s*\n\s*f?"', "", texts)


SOURCE = re.sub(r"\{[^{}]*\}", "#", _joined(["drivers", "station"]))


@pytest.mark.parametrize("words", sorted(set(SEEN)))
def test_what_the_operator_sees_is_what_the_code_says(words: str) -> None:
    pattern = re.escape(words).replace(r"1\.8\ s", r"#\ s").replace(r"2\ s", r"#\ s")
    for value in ("counts", "triad"):
        pattern = pattern.replace(value, "#")
    assert re.search(pattern, SOURCE), pattern


def test_every_test_named_is_there() -> None:
    tests = _joined(["tests"])
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
