"""What the pages name is there: links, headings, files, commands with their options, proofs."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from station import cli
from tests.paths import ROOT
from tests.proof.registry import PROOFS

PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
PACKAGES = ("station", "drivers", "procedures", "fixtures_db", "tests", "docs")
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^\s*```.*?^\s*```", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"`([^`]+)`")
NAMED_FILE = re.compile(r"`((?:station|drivers|procedures|fixtures_db|tests|docs)/[\w./]+\.\w+)[`:]")
NAME_IN_FILE = re.compile(rf"`(\w+)` (?:in|of) {NAMED_FILE.pattern.replace('[`:]', '`')}")
NAMED_SOURCE = re.compile(r"`((?:[a-z_0-9]+/)*[a-z_0-9]+\.py)[`:]")
TITLE = re.compile(r"^```\w+ title=\"([\w.]+)\"$", re.MULTILINE)
PROOF = re.compile(r"python -m\s+tests\.proof ([a-z][\w-]+)")
COMMAND_LINE = re.compile(r"^ *(?:\$ )?(station [a-z].*)$", re.MULTILINE)
SOURCES = [str(p.relative_to(ROOT)) for folder in PACKAGES for p in (ROOT / folder).rglob("*.py")]
every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)


def prose(page: Path) -> str:
    """Return a page without its blocks of code."""
    return FENCE.sub("", page.read_text(encoding="utf-8"))


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ +(.+)$", prose(page), re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {heading.strip().replace(" ", "-") for heading in plain}


@every_page
def test_every_link_leads_somewhere(page: Path) -> None:
    for target in LINK.findall(prose(page)):
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        there = page.parent / name if name else page
        assert there.exists(), target
        assert not anchor or anchor in anchors(there), target


@every_page
def test_every_source_file_that_is_named_is_there(page: Path) -> None:
    if page.stem != "CHANGELOG":  # which names files as they were
        written = TITLE.findall(page.read_text(encoding="utf-8"))  # by the reader, as the page says
        named = set(NAMED_SOURCE.findall(prose(page))) - set(written)
        assert [path for path in named if not any(f"/{file}".endswith(f"/{path}") for file in SOURCES)] == []


def test_the_front_page_leads_to_every_other() -> None:
    assert "docs/README.md" in LINK.findall(prose(ROOT / "README.md"))
    docs = ROOT / "docs"
    pages = {str(page.relative_to(docs)) for page in docs.rglob("*.md")}
    assert pages - {"README.md"} <= set(LINK.findall(prose(docs / "README.md")))


@every_page
def test_every_file_and_proof_that_is_named_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name in (name for name in NAMED_FILE.findall(text) if "NAME" not in name):  # that is yet to be written
        assert (ROOT / name).exists(), name
    assert set(PROOF.findall(text)) <= set(PROOFS)


@every_page
def test_every_table_and_function_that_is_stated_to_be_in_a_file_is_there(page: Path) -> None:
    for name, file in NAME_IN_FILE.findall(" ".join(prose(page).split())):
        text = (ROOT / file).read_text(encoding="utf-8")
        assert re.search(rf"^\s*(def |class )?{name}\b", text, re.MULTILINE), f"{file} has no {name}"


def command_lines(page: Path) -> Iterator[list[str]]:
    """Yield the words of each command line on a page, in a block or in the text, up to a pipe or a comment."""
    text = page.read_text(encoding="utf-8")
    spans = (" ".join(span.split()) for span in SPAN.findall(prose(page)))
    lines = COMMAND_LINE.findall("\n".join(FENCE.findall(text)))
    for line in (*lines, *(span for span in spans if re.match(r"station [a-z]", span))):
        plain = re.split(r" [|;&>]", line.replace("[", " ").replace("]", " ").rstrip("\\ "))[0]
        yield shlex.split(plain, comments=True)[1:]


@every_page
def test_every_command_and_option_that_is_named_exists(page: Path) -> None:
    is_of_today = page.stem != "CHANGELOG" and not page.read_text(encoding="utf-8").startswith("<!-- Generated")
    for words in command_lines(page) if is_of_today else ():
        command: Any = typer.main.get_command(cli.app)
        options = [word.partition("=")[0] for word in words if word.startswith("--") and word != "--help"]
        while hasattr(command, "get_command") and words:
            name, *words = words
            command = command.get_command(None, name)
            assert command is not None, name
        known = {option for given in command.params for option in (*given.opts, *given.secondary_opts)}
        assert set(options) <= known, (command.name, options)
