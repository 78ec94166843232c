"""The tutorials are run as they stand: files are written, commands give the output that is printed.

A block of ``console`` has commands after ``$ ``, each with its output; ``...`` stands for any text, as in doctest,
and blanks and line breaks count alike. A command that ends in `` &`` runs next to the others: its first lines are
compared. A block with a title is a file.
"""

import doctest
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from tests.paths import ROOT

FOLDER = ROOT / "docs/tutorials"
TUTORIALS = (
    ("first-calibration", "monitor"),
    ("diagnose-a-log",),
    ("simulated-imu-in-pytest",),
)  # in one folder each
BLOCK = re.compile(r"^```(\w+)(?: title=\"([\w.]+)\")?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ (.+)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)
LIMIT_S = 600


@contextmanager
def in_background(command: str, lines: int, folder: Path, names: Mapping[str, str]) -> Iterator[str]:
    """Run a command next to others and yield its first lines; end it at last."""
    program = subprocess.Popen(
        ["bash", "-c", f"exec {command}"], cwd=folder, env=names, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    assert program.stdout is not None
    try:
        yield "".join(program.stdout.readline() for _ in range(lines))
    finally:
        program.terminate()
        program.wait()
        program.stdout.close()


def compare(command: str, expected: str, got: str) -> None:
    """Fail where an output is not as printed."""
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    if not doctest.OutputChecker().check_output(expected, got, flags):
        pytest.fail(f"$ {command}\n-- printed on the page:\n{expected}\n-- got:\n{got}", pytrace=False)


def test_every_tutorial_is_run() -> None:
    assert {page.stem for page in FOLDER.glob("*.md")} == {name for names in TUTORIALS for name in names}


@pytest.mark.parametrize("pages", TUTORIALS, ids=lambda names: names[0])
def test_a_tutorial_does_what_it_says(pages: tuple[str, ...], tmp_path: Path) -> None:
    text = "\n".join((FOLDER / f"{page}.md").read_text(encoding="utf-8") for page in pages)
    names = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "COLUMNS": "80"}
    names = {name: value for name, value in names.items() if not name.startswith("PYTEST_")}
    with ExitStack() as running:
        for language, title, block in BLOCK.findall(text):
            if title:
                (tmp_path / title).write_text(block, encoding="utf-8")
            for command, expected in COMMAND.findall(block) if language == "console" else ():
                if command.startswith("export "):
                    name, _, value = command.removeprefix("export ").partition("=")
                    names[name] = value
                elif command.endswith(" &"):
                    lines = max(1, expected.count("\n") - expected.startswith("..."))
                    got = running.enter_context(in_background(command.removesuffix(" &"), lines, tmp_path, names))
                    compare(command, expected, got)
                else:
                    done = subprocess.run(
                        ["bash", "-c", command], cwd=tmp_path, env=names, stdin=subprocess.DEVNULL,
                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LIMIT_S,
                    )  # fmt: skip
                    compare(command, expected, done.stdout)
