"""Each number that somebody chose stands in `docs/numbers` with what it is, and the code has what is stated."""

import ast
import re

from tests.numbers_in_code import numbers_in_code
from tests.paths import ROOT

ROW = re.compile(r"\| `([\w/.]+\.py)` \| `(.+?)` \| `(.+?)` \|.*\|")
PAGES = sorted((ROOT / "docs/numbers").glob("*.md"))


def stated() -> dict[tuple[str, str], str]:
    """Return the values that the pages state, by file and name."""
    lines = [line for page in PAGES for line in page.read_text(encoding="utf-8").splitlines() if line[:3] == "| `"]
    rows = [row.groups() for line in lines if (row := ROW.fullmatch(line))]
    assert len(rows) == len(lines), "a row cannot be read"
    assert len(rows) == len({row[:2] for row in rows}), "a number stands twice"
    return {(file, name): ast.unparse(ast.parse(value)) for file, name, value in rows}


def test_the_code_has_the_numbers_that_the_pages_state() -> None:
    found = numbers_in_code()
    other = [(*key, found.get(key), value) for key, value in stated().items() if found.get(key) != value]
    assert not other, "file, name, found, stated: put the code right, or the page with its reason"


def test_every_number_that_somebody_chose_is_stated() -> None:
    pages = stated()
    missing = [(*key, value) for key, value in numbers_in_code().items() if key not in pages]
    assert not missing, "write each into the page of its folder as `file`, `name`, `value`, what it is"


def test_the_front_page_of_numbers_leads_to_every_other() -> None:
    front = (ROOT / "docs/numbers.md").read_text(encoding="utf-8")
    assert {page.name for page in PAGES} == set(re.findall(r"\(numbers/([\w-]+\.md)\)", front))
