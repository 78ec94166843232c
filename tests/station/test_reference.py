"""The generated pages are up to date, and every format of files is on its page."""

import re

import pytest

from docs.generate import INPUTS, PAGES, REFERENCE
from station.results.result_formats import RESULTS
from tests.paths import ROOT

ELSEWHERE = {
    "attitude-log/1": "docs/explanation/attitude.md",
    "can-map/1": "docs/how-to/can.md",
    "fixtures/1": "docs/reference/file-formats.md",
    "evidence/1": "docs/contributing/station-tests.md",
}
INTERNAL = {"kept/1"}  # what `station resolve` keeps of its own between two runs


@pytest.mark.parametrize("name", PAGES)
def test_a_generated_page_is_up_to_date(name: str) -> None:
    assert (REFERENCE / name).read_text(encoding="utf-8") == PAGES[name](), "run: python docs/generate.py"


def test_every_format_that_the_program_names_is_described() -> None:
    sources = [path for folder in ("station", "drivers", "fixtures_db") for path in (ROOT / folder).rglob("*.py")]
    named = {name for path in sources for name in re.findall(r'"([a-z-]+/1)"', path.read_text(encoding="utf-8"))}
    described = {*INPUTS, *RESULTS, *ELSEWHERE, *INTERNAL}
    assert named <= described
    for name, page in ELSEWHERE.items():
        assert name in (ROOT / page).read_text(encoding="utf-8")
