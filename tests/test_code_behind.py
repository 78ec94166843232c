"""What is found by reading imports is what Python imports, and every line of it counts."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from procedures.frames import rotation
from tests.code_behind import digest, modules_behind, modules_named
from tests.computed_once import COMPUTED, pickled
from tests.paths import ROOT

IMPORTS = """
import sys
from importlib import import_module

def ours():
    return [each for each in sys.modules if each.split(".")[0] == "procedures"]  # they import no other of ours

for module in sys.argv[1:]:
    for each in ours():
        del sys.modules[each]
    import_module(module)
    print(module, *ours())
"""


def test_it_is_what_python_imports() -> None:
    modules = sorted({module for module, _ in COMPUTED})
    command = [sys.executable, "-c", IMPORTS, *modules]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    told = [line.split() for line in done.stdout.splitlines()]
    assert [module for module, *_ in told] == modules
    for module, *imported in told:
        assert set(imported) <= modules_behind(module)


@pytest.mark.parametrize(
    "line",
    [
        "from procedures.b import c",
        "from procedures.b.c import VALUE",
        "import procedures.b.c",
        "def later():\n    from procedures.b import (\n        other,\n        c,\n    )",
    ],
)
def test_each_kind_of_import_is_followed_and_a_changed_line_changes_the_hash(tmp_path: Path, line: str) -> None:
    (tmp_path / "procedures" / "b").mkdir(parents=True)
    texts = {"a": line, "b/__init__": "from procedures.d import D", "b/c": "VALUE = 1", "d": "D = 1", "e": "E = 1"}
    for name, text in texts.items():
        (tmp_path / "procedures" / f"{name}.py").write_text(f"{text}\n")
    found = modules_behind("procedures.a", tmp_path)
    assert found == {f"procedures.{each}" for each in ("a", "b", "b.c", "d")}
    before = digest(found, tmp_path)
    (tmp_path / "procedures" / "e.py").write_text("E = 2\n")
    assert digest(found, tmp_path) == before
    (tmp_path / "procedures" / "d.py").write_text("D = 2\n")
    assert digest(found, tmp_path) != before


def test_modules_of_classes_and_functions_are_named_in_what_is_pickled() -> None:
    question = pickled(((rotation, np.arange(1000.0)), {"of": Path()}))
    assert question is not None
    assert modules_named(question) == {"procedures.frames"}
