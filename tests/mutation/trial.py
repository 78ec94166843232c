"""A copy of the tree in which mutants are planted and tests run, and what became of each mutant."""

import os
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

from tests.mutation.operators import Mutant

BATCH = 4  # test files run together, the nearest first
UNKNOWN_S, START_S, TIMES = 60.0, 60.0, 4.0  # limit: so often what the unmutated tests take, and the start


@dataclass
class Tree:
    """A copy of the tree of ``root`` at ``at``; ``cost`` is what each test file takes [s]."""

    root: Path
    at: Path
    packages: tuple[str, ...]
    cost: dict[str, float] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)  # tests that fail unmutated, here
    sound: set[str] = field(default_factory=set)  # that passed unmutated

    def lay(self) -> None:
        """Copy what git knows of, and check that the copy is imported: the installed package is editable."""
        asked = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        names = subprocess.run(asked, cwd=self.root, capture_output=True, text=True, check=True).stdout
        shutil.rmtree(self.at, ignore_errors=True)
        for name in names.splitlines():
            there = self.at / name
            there.parent.mkdir(parents=True, exist_ok=True)
            if (self.root / name).is_file():
                shutil.copy2(self.root / name, there)  # no hard links: an editor may write through them
        for package in self.packages:
            asked = [sys.executable, "-c", f"import {package}; print(*{package}.__path__)"]
            found = subprocess.run(
                asked, cwd=self.at, env=self.environment(), capture_output=True, text=True, check=True
            )
            if set(found.stdout.split()) != {str(self.at / package)}:
                raise RuntimeError(
                    f"{package} is imported from {found.stdout.strip()}; expected the copy {self.at}"
                )

    def environment(self, kernels: Path | None = None) -> dict[str, str]:
        """Return the environment of the tests: the copy is imported, its kernels compiled for itself."""
        data = os.environ.get("STATION_DATA", str((self.root / "../shared/data").resolve()))
        own = {
            "PYTHONPATH": str(self.at), "STATION_DATA": data,
            "NUMBA_CACHE_DIR": str(kernels or self.at.with_name(self.at.name + ".kernels")),
        }  # fmt: skip
        return {k: v for k, v in os.environ.items() if k not in {"STATION_DB", "STATION_CONFIG"}} | own

    def outcome(self, mutant: Mutant, tests: list[str]) -> str:
        """Return the test that kills a mutant, "timeout", or "" if it survives."""
        for first in range(0, len(tests), BATCH):
            some = tests[first : first + BATCH]
            with tempfile.TemporaryDirectory() as kernels:
                is_kernel = "numba" in mutant.source or "kernel_options" in mutant.source
                while killer := self._run(some, mutant, Path(kernels) if is_kernel else None):
                    if killer == "timeout" or self._is_sound(killer):
                        return killer
                    self.broken.add(killer)
        return ""

    def _is_sound(self, test: str) -> bool:
        if test not in self.sound and not self._run([test]):
            self.sound.add(test)
        return test in self.sound

    def _run(self, tests: list[str], mutant: Mutant | None = None, kernels: Path | None = None) -> str:
        """Run tests until one fails; return its name, or "" if none did."""
        limit = START_S + TIMES * sum(self.cost.get(test.split("::")[0], UNKNOWN_S) for test in tests)
        report = self.at.with_name(self.at.name + ".xml")
        report.unlink(missing_ok=True)
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider",
                   "--continue-on-collection-errors", f"--junitxml={report}", *tests]  # fmt: skip
        command += [f"--deselect={each}" for each in self.broken]
        kept = self._plant(mutant)
        try:
            done = subprocess.run(
                command, cwd=self.at, env=self.environment(kernels), capture_output=True, timeout=limit
            )
        except subprocess.TimeoutExpired:
            return "timeout"
        finally:
            if mutant is not None and kept is not None:
                kept.replace(self.at / mutant.file)
        cases = list(ET.parse(report).iter("testcase")) if report.exists() else []
        if done.returncode in {0, 5}:
            for test in {each for each in tests if "::" not in each}:
                self.cost[test] = sum(float(case.get("time", 0)) for case in cases if _file(case) == test)
            return ""
        failed = [case for case in cases if case.find("failure") is not None or case.find("error") is not None]
        files = [each.split("::")[0] for each in tests]
        return f"{_file(failed[0])}::{failed[0].get('name')}" if failed and _file(failed[0]) in files else tests[0]

    def _plant(self, mutant: Mutant | None) -> Path | None:
        if mutant is None:
            return None
        there = self.at / mutant.file
        kept = there.with_suffix(".kept")
        there.replace(kept)
        there.write_text(mutant.source, encoding="utf-8")
        return kept


def _file(case: ET.Element) -> str:
    return case.get("classname", "").replace(".", "/") + ".py"
