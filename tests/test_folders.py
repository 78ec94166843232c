"""A folder has few files and says what flows through it; what docstrings say of modules is there."""

import ast
import re
from pathlib import Path

import pytest

from tests.paths import ROOT
from tests.test_no_circles import PACKAGES, modules

FOLDERS = sorted({path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")})
LIST = ("station/commands", "fixtures_db/migrations")  # a command, a version of the schema: a file each
MODULE = re.compile(rf"`((?:{'|'.join(PACKAGES)})(?:\.\w+)+)`")


def docstrings(path: Path) -> str:
    """Return the docstrings of a file, one after the other."""
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return "\n".join(ast.get_docstring(node) or "" for node in ast.walk(tree) if isinstance(node, kinds))


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_a_folder_has_five_to_fifteen_files_and_some_lines_about_them(folder: Path) -> None:
    if str(folder.relative_to(ROOT)).startswith(LIST):
        return
    files = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    assert 4 <= len(files) <= 15
    assert len((ast.get_docstring(ast.parse((folder / "__init__.py").read_text())) or "").splitlines()) >= 3


def test_modules_that_docstrings_name_are_there() -> None:
    known = modules()
    for file in known.values():
        for name in MODULE.findall(docstrings(file)):
            assert {name, name.rpartition(".")[0], name.rsplit(".", 2)[0]} & known.keys(), (file, name)
