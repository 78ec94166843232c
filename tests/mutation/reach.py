"""Which functions each file of tests calls, and how long it takes: found by running it once, kept in a folder."""

import ast
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from threading import Lock
from typing import Any

from tests.mutation.operators import Mutant

UNKNOWN_S = 60.0


class Reach:
    """What each file of tests called when it was last traced, by the file's text."""

    def __init__(self, kept: Path) -> None:
        self.kept = kept
        kept.mkdir(parents=True, exist_ok=True)
        read = [json.loads(each.read_text()) for each in sorted(kept.glob("*.json"))]
        self.of: dict[str, dict[str, Any]] = {each["test"]: each for each in read}
        self.text = {test: str(found["text"]) for test, found in self.of.items()}
        self.lock = Lock()

    def claimed(self, root: Path, tests: Iterable[str]) -> Iterator[tuple[str, str]]:
        """Yield the files of tests not traced as they are now, with their hash, for this caller to trace."""
        for each in sorted(tests):
            text = hashlib.sha256((root / each).read_bytes()).hexdigest()
            with self.lock:
                claimed = self.text.get(each) != text
                self.text[each] = text
            if claimed:
                yield each, text

    def keep(self, test: str, text: str, found: Mapping[str, Any]) -> None:
        """Keep what a file of tests called."""
        without = {"seconds": UNKNOWN_S, "calls": {}, "passed": []}
        with self.lock:
            self.of[test] = without | found | {"text": text, "test": test}
        new = self.kept / f"{test.replace('/', '.')}.new"  # one that is cut short is none
        new.write_text(json.dumps(self.of[test], indent=0))
        new.replace(new.with_suffix(".json"))

    def seconds(self, test: str) -> float:
        """Return what a file of tests takes."""
        return float(self.of.get(test, {}).get("seconds", UNKNOWN_S))

    def has_passed(self, test: str) -> bool:
        """Return whether a test, or a file of tests, passed as it was traced."""
        found = self.of.get(test.split("::")[0], {"failed": "unknown", "passed": ()})
        return test in found["passed"] if "::" in test else not found["failed"]

    def callers(self, mutant: Mutant, function: str, graph: Mapping[str, set[str]]) -> dict[str, list[str]]:
        """Return, by their file, the tests that call the mutant's function.

        Of a constant those that call a function of its file; if there are none, as of a kernel, whose calls are
        not seen, those that call one of a file that imports it.
        """
        users = [importer for importer, imported in graph.items() if mutant.file in imported]
        return (
            (self._calling([f"{mutant.file}:{function}"]) if function else {})
            or self._calling([f"{mutant.file}:"])
            or self._calling([f"{each}:" for each in users])
        )

    def _calling(self, asked: Sequence[str]) -> dict[str, list[str]]:
        names = {each for each in asked if not each.endswith(":")}
        files = {each for each in asked if each.endswith(":")}
        found: dict[str, list[str]] = {}
        for test, traced in [*self.of.items()]:
            for called, tests in traced["calls"].items():
                if called in names or f"{called.split(':')[0]}:" in files:
                    found.setdefault(test, []).extend(tests)
        return found


def function_at(source: str, line: int) -> str:
    """Return the outermost function whose body has a line, as ``Class.function``; "" if none has."""
    at, name = ast.parse(source).body, ""
    while True:
        inside = [each for each in at if each.lineno <= line <= (each.end_lineno or 0)]
        if not inside or not isinstance(inside[0], ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            return ""
        name = f"{name}.{inside[0].name}".lstrip(".")
        if not isinstance(inside[0], ast.ClassDef):
            return name if line >= inside[0].body[0].lineno else ""
        at = inside[0].body
