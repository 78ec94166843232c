"""Which Python `.venv` is made of, as ``make --dry-run`` says it."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.paths import ROOT


def chosen(folder: Path, own: str, system: str, *given: str) -> str:
    """Return the Python that make takes where `python3` and the system's say something about their version."""
    for name, says in (("python3", own), ("system", system)):
        (folder / name).write_text(f"#!/bin/sh\n{says}\n")
        (folder / name).chmod(0o755)
    make = shutil.which("make")
    if make is None:
        pytest.skip("no make")
    others = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "PYTHON"))}
    words = [f"VENV={folder / 'v'}", f"SYSTEM={folder / 'system'}", *given, f"{folder / 'v'}/bin/python"]
    found = subprocess.run(
        [make, "--dry-run", *words], cwd=ROOT, env=others | {"PATH": f"{folder}:/usr/bin:/bin"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert found.stderr == ""
    return found.stdout.splitlines()[-1].split()[0].rpartition("/")[2]


@pytest.mark.parametrize(
    ("own", "system", "taken"),
    [
        ("echo 3 11", "echo 3 11", "system"),
        ("echo 3 12", "echo 3 11", "python3"),  # who has another version wants that one
        ("echo 3 11", "echo no module ensurepip >&2; exit 1", "python3"),
        ("exit 1", "exit 1", "python3"),  # whose message is plainer
    ],
)
def test_the_systems_python_is_taken_where_it_is_the_same_version(
    tmp_path: Path, own: str, system: str, taken: str
) -> None:
    assert chosen(tmp_path, own, system) == taken


def test_a_python_that_is_given_is_taken(tmp_path: Path) -> None:
    assert chosen(tmp_path, "echo 3 11", "echo 3 11", "PYTHON=mine") == "mine"
