"""Paths among arguments: where the path leads to a small file or folder, what is in it goes with it."""

import re
from pathlib import Path
from typing import Any

from tests.paths import MEMORY, ROOT

MOST_BYTES, MOST_FILES = 60_000, 30
TEMPORARY = re.compile(rf"^(?:/tmp|{MEMORY})/pytest-of-[^/]+/pytest-\d+/[^/]+/?")
HERE = [Path()]  # the folder that calls are replayed in


def reduced_path(path: Path) -> tuple[Any, ...]:
    """Return how a path is pickled: absolute, with what it leads to if that was made by a test."""
    text = str(path)
    if path.is_absolute() and path.is_relative_to(ROOT):
        return _in_tree, (str(path.relative_to(ROOT)),)
    if within := TEMPORARY.match(text):
        return placed, (text[within.end() :], contents(path))
    return Path, (text,)


def contents(path: Path) -> dict[str, bytes]:
    """Return the files of a folder, "" for a file itself, by their names."""
    if path.is_file():
        files = [path]
    else:
        files = [each for each in sorted(path.rglob("*")) if each.is_file()] if path.is_dir() else []
    if len(files) > MOST_FILES or sum(each.stat().st_size for each in files) > MOST_BYTES:
        raise OverflowError
    found = {str(each.relative_to(path)) if each != path else "": each.read_bytes() for each in files}
    return found if files or not path.is_dir() else {"/": b""}


def placed(name: str, files: dict[str, bytes]) -> Path:
    """Return a path in the folder of this replay, with these files there."""
    path = HERE[0] / name if name else HERE[0]
    for each, content in files.items():
        if each == "/":
            path.mkdir(parents=True, exist_ok=True)
            continue
        there = path / each if each else path
        there.parent.mkdir(parents=True, exist_ok=True)
        there.write_bytes(content)
    return path


def _in_tree(name: str) -> Path:
    return ROOT / name
