"""Which Python `.venv` is made of, as ``make --dry-run`` says it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT

PLAIN = "sys.version_info = (3, 11, 7); sysconfig.get_config_var = lambda name: '--enable-shared'"
NEWER = "sys.version_info = (3, 12, 0); sysconfig.get_config_var = lambda name: None"
OPTIMISED = "sys.version_info = (3, 11, 7); sysconfig.get_config_var = lambda name: '--enable-optimizations'"
PYPY = f"{PLAIN}; sys.implementation.name = 'pypy'"
DEBIANS = "sys.version_info = (3, 11, 2)"
WITHOUT_VENV = f"{DEBIANS}; sys.modules['ensurepip'] = None"
BROKEN = "sys.exit(1)"


def chosen(folder: Path, own: str, system: str | None, *given: str, **environment: str) -> str:
    """Return what make takes where `python3` and the system's are this interpreter after some statements."""
    for name, statements in (("python3", own), ("system", system)):
        if statements is not None:
            begin = f"import sys, sysconfig; {statements}; exec(sys.argv[2])"
            (folder / name).write_text(f'#!/bin/sh\nexec {sys.executable} -c "{begin}" "$@"\n')
            (folder / name).chmod(0o755)
    make = shutil.which("make")
    if make is None:
        pytest.skip("no make")
    others = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "PYTHON"))}
    words = [f"VENV={folder / 'v'}", f"SYSTEM={folder / 'system'}", *given, f"{folder / 'v'}/bin/python"]
    found = subprocess.run(
        [make, "--dry-run", *words], cwd=ROOT, env=others | {"PATH": f"{folder}:/usr/bin:/bin"} | environment,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert found.stderr == ""
    return found.stdout.splitlines()[-1].split()[0].rpartition("/")[2]


@pytest.mark.parametrize(
    ("own", "system", "taken"),
    [
        (PLAIN, DEBIANS, "system"),
        (NEWER, DEBIANS, "python3"),
        (OPTIMISED, DEBIANS, "python3"),
        (PYPY, DEBIANS, "python3"),
        (PLAIN, WITHOUT_VENV, "python3"),
        (PLAIN, None, "python3"),
        (BROKEN, BROKEN, "python3"),
    ],
)
def test_the_systems_python_goes_before_a_slower_one_of_its_version(
    tmp_path: Path, own: str, system: str | None, taken: str
) -> None:
    assert chosen(tmp_path, own, system) == taken


def test_a_python_that_is_named_is_taken(tmp_path: Path) -> None:
    assert chosen(tmp_path, PLAIN, DEBIANS, "PYTHON=mine") == "mine"
    assert chosen(tmp_path, PLAIN, DEBIANS, PYTHON="mine") == "mine"
