"""Which files what a module says depends on: its own, those of its packages, and all that these import."""

import hashlib
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from tests.paths import ROOT

PACKAGES = ("procedures", "drivers", "fixtures_db", "station", "tests")
OURS = rf"(?:{'|'.join(PACKAGES)})[\w.]*"
IMPORT = re.compile(rf"^\s*(?:from\s+({OURS})\s+import\s+(\([^)]*\)|[^\n]*)|import\s+({OURS}))", re.MULTILINE)


def modules_behind(module: str, root: Path = ROOT) -> frozenset[str]:
    """Return a module and all of ours that it imports, directly or not, also those that a function imports."""
    found, left = set[str](), {module}
    while left:
        name = left.pop()
        if name not in found and file_of(name, root) is not None:
            found.add(name)
            left |= _imported(name, root) | {name.rpartition(".")[0]}  # a package runs before what is in it
    return frozenset(found)


def digest(modules: Iterable[str], root: Path = ROOT) -> bytes:
    """Return a hash of the text of some modules, and of the other files of the packages among them."""
    found = hashlib.blake2b(digest_size=20)
    for name in sorted(modules):
        file = file_of(name, root)
        found.update(f"{name}\n".encode() + (b"" if file is None else file.read_bytes()))
        if file is not None and file.stem == "__init__":
            others = sorted(each for each in file.parent.iterdir() if each.is_file() and each.suffix != ".py")
            found.update(b"".join(each.name.encode() + each.read_bytes() for each in others))
    return found.digest()


def modules_named(text: bytes) -> set[str]:
    """Return what of ours is named in something pickled: the modules of its classes and functions."""
    found = set[str]()
    for package in PACKAGES:
        word, at = f"{package}.".encode(), 0
        while (at := text.find(word, at)) >= 0:
            name = re.compile(rb"[\w.]+").match(text, at)
            assert name is not None
            found.add(name[0].decode())
            at = name.end()
    return found


@cache
def file_of(module: str, root: Path) -> Path | None:
    """Return a module's file, None where there is none of that name."""
    path = root.joinpath(*module.split("."))
    here = (path / "__init__.py", path.with_suffix(".py")) if module else ()
    return next((each for each in here if each.is_file()), None)


@cache
def _imported(module: str, root: Path) -> frozenset[str]:
    file = file_of(module, root)
    assert file is not None
    found = set[str]()
    for package, names, alone in IMPORT.findall(file.read_text()):
        found.add(package or alone)
        found |= {f"{package}.{name}" for name in re.findall(r"\w+", names) if package}  # some may be modules
    return frozenset(found)
