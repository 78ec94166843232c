"""A copy of the tree in which mutants are planted and tests run, and what became of each mutant."""

import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.mutation.collected import Collected
from tests.mutation.operators import Mutant
from tests.mutation.reach import Reach
from tests.mutation.warm import CRASH, TIMEOUT, UNFIT

BATCH = 3  # test files run together in a process of their own
START_S, TIMES = 30.0, 4.0  # limit: so often what the unmutated tests take; all limits are of processor time
ENOUGH_S = 2.0  # of a file of tests near a mutant, before others have their turn; shows what it calls
TRACE_S, WHOLE_S = 60.0, 600.0  # limits of a file of tests, traced for some seconds, and as a whole


@dataclass
class Tree:
    """A copy of the tree of ``root`` at ``at``, and the process that has collected its tests."""

    root: Path
    at: Path
    packages: tuple[str, ...]
    reach: Reach
    broken: set[str] = field(default_factory=set)  # tests that fail unmutated, here
    sound: set[str] = field(default_factory=set)  # that passed unmutated
    passed: set[str] = field(default_factory=set)  # that passed with the mutant that is tried now
    left: list[str] = field(default_factory=list)  # files of tests that were not all run, of those asked for last
    collected: Collected | None = None

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
        self.collected = Collected(self.at, ["tests"], self.environment())

    def end(self) -> None:
        """End the process that has collected the tests."""
        self._collected.end()

    def environment(self, kernels: Path | None = None) -> dict[str, str]:
        """Return the environment of the tests: the copy is imported, its kernels compiled for itself."""
        data = os.environ.get("STATION_DATA", str((self.root / "../shared/data").resolve()))
        own = {
            "PYTHONPATH": str(self.at), "STATION_DATA": data, "OPENBLAS_NUM_THREADS": "1",
            "PYTHONDONTWRITEBYTECODE": "1",  # a mutant's could stand for the next mutant of the same second
            "NUMBA_CACHE_DIR": str(kernels or self.kernels),
            "STATION_TESTS_COMPUTE": "1",  # what is known from before calls nothing
        }  # fmt: skip
        return {k: v for k, v in os.environ.items() if k not in {"STATION_DB", "STATION_CONFIG"}} | own

    def trace(self, test: str, *, is_whole: bool = False) -> dict[str, Any]:
        """Run a file of tests, some seconds of it or the whole; return what it called, and its seconds."""
        if is_whole:
            return self._collected.run([test], WHOLE_S, trace=True)
        return self._collected.run([test], TRACE_S, trace=True, enough_s=ENOUGH_S)

    def by_calls(self, mutant: Mutant, function: str, tests: list[str]) -> str:
        """Return which of the tests of stored calls kills a mutant; kernels are tried as Python."""
        self.passed, killer = set(), UNFIT
        if tests and function and not is_kernel(mutant):
            killer = self._killer(lambda: self._replaced(mutant, function, tests))
        if tests and (killer == UNFIT or (not killer and self._is_called_by_imports(mutant, function))):
            killer = self._killer(lambda: self._anew(mutant, tests, python=is_kernel(mutant)))
        return killer if tests else ""

    def nearby(self, mutant: Mutant, function: str, files: list[str], most_s: float) -> tuple[str, list[str]]:
        """Return which of the tests near a mutant kills it in some seconds of each file, and the files not run."""
        self.left = files
        if not function or is_kernel(mutant):
            return "", files
        how = {"enough_s": ENOUGH_S, "most_s": most_s}
        killer = self._killer(lambda: self._replaced(mutant, function, files, **how))
        return "" if killer == UNFIT else killer, self.left

    def outcome(self, mutant: Mutant, function: str, tests: list[str], anew: list[str]) -> str:
        """Return the test that kills a mutant of a ``function``, "timeout" or "crash", or "" if it survives.

        ``anew`` are the files near it: tried in a process of its own if it is called as modules are imported.
        """
        files, killer = [each for each in tests if "::" not in each], UNFIT
        if function and not is_kernel(mutant):
            killer = self._killer(lambda: self._replaced(mutant, function, tests))
            if killer != UNFIT and (killer or not self._is_called_by_imports(mutant, function)):
                return killer
            files = files if killer else anew[:BATCH]
        for first in range(0, len(files), BATCH):
            some = files[first : first + BATCH]
            if killer := self._killer(lambda some=some: self._anew(mutant, some)):
                return killer
        return ""

    @property
    def kernels(self) -> Path:
        """Where numba keeps what it has compiled of the unmutated tree."""
        return self.at.with_name(self.at.name + ".kernels")

    @property
    def _collected(self) -> Collected:
        assert self.collected is not None, "lay the tree first"
        return self.collected

    def _killer(self, run: Callable[[], str]) -> str:
        """Return the first test that fails and is none of those that fail without the mutant."""
        while killer := run():
            if killer in {TIMEOUT, CRASH, UNFIT} or self._is_sound(killer):
                return killer
            self.broken.add(killer)
        return ""

    def _is_sound(self, test: str) -> bool:
        if test not in self.sound:
            if self.reach.has_passed(test) or not self._collected.run([test], TRACE_S)["failed"]:
                self.sound.add(test)
        return test in self.sound

    def _limit(self, tests: list[str], most_s: float = math.inf) -> float:
        """Return a limit for a run of tests, which begins no file after ``most_s``."""
        seconds = sum(self.reach.seconds(each) for each in tests if "::" not in each)
        return START_S + TIMES * min(seconds, most_s)

    def _is_called_by_imports(self, mutant: Mutant, function: str) -> bool:
        return f"{mutant.file}:{function}" in self._collected.as_imported

    def _replaced(self, mutant: Mutant, function: str, tests: list[str], **how: float) -> str:
        """Run tests in a fork of the process that has collected them, the function replaced."""
        with self._planted(mutant):
            what = {"file": mutant.file, "function": function, "left_out": sorted(self.broken | self.passed)}
            limit_s = self._limit(tests, how.get("most_s", math.inf))
            answer = self._collected.run(tests, limit_s, **what, **how)
        self.passed |= set(answer.get("passed", ()))
        self.left = answer.get("left", tests)
        return str(answer["failed"])

    def _anew(self, mutant: Mutant, tests: list[str], *, python: bool = False) -> str:
        """Run tests in a process of their own, which imports the mutant; kernels compiled, or as ``python``."""
        with self._planted(mutant), tempfile.TemporaryDirectory() as folder:
            kernels = Path(folder) / "kernels"
            if is_kernel(mutant) and not python:
                shutil.copytree(self.kernels, kernels)
            environment = self.environment(kernels if is_kernel(mutant) else None)
            environment |= {"NUMBA_DISABLE_JIT": "1"} if python else {}
            own = Collected(self.at, tests, environment)
            failed = own.failed or own.run(tests, self._limit(tests), left_out=sorted(self.broken))["failed"]
            own.end()
            return str(failed)

    @contextmanager
    def _planted(self, mutant: Mutant) -> Iterator[None]:
        there = self.at / mutant.file
        kept = there.with_suffix(".kept")
        there.replace(kept)
        try:
            there.write_text(mutant.source, encoding="utf-8")
            yield
        finally:
            kept.replace(there)


def is_kernel(mutant: Mutant) -> bool:
    """Whether a mutant's file has compiled kernels, whose code is not to be replaced."""
    return "numba" in mutant.source or "kernel_options" in mutant.source
