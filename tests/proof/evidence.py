"""What a proof measured, and the JSON file in docs/evidence that holds it: format "evidence/1"."""

import json
import os
import platform
import re
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from tests.paths import ROOT

FORMAT = "evidence/1"
EVIDENCE = ROOT / "docs" / "evidence"
PROGRAM = ("drivers", "fixtures_db", "procedures", "station")

Item = TypeVar("Item")
Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Figure:
    """A number with its unit, or a count ``of`` so many; as asked between ``at_least`` and ``at_most``."""

    value: float
    unit: str = ""
    at_most: float | None = None
    at_least: float | None = None
    of: int | None = None

    @property
    def is_met(self) -> bool:
        """Return whether the number is as asked; a number that is none (NaN) is not."""
        above = self.at_least is None or self.value >= self.at_least
        return above and (self.at_most is None or self.value <= self.at_most)


Result = Mapping[str, Figure]


def zero(count: int) -> Figure:
    """Return a count of what must not happen."""
    return Figure(count, at_most=0)


@dataclass(frozen=True, slots=True)
class Proof:
    """A proof of the table in `tests.proof.registry`.

    ``module`` of `tests.benchmarks` is where its function ``proof(size, seed)`` stands, which returns a `Result`;
    ``module:function`` for another name. ``shows`` is a sentence; ``unit`` says what is counted by its size;
    ``size`` and ``quick`` are how many of these `make proof` runs, and ``--quick``.
    """

    name: str
    module: str
    shows: str
    unit: str
    size: int
    quick: int

    @property
    def file(self) -> Path:
        """Return where its evidence is kept."""
        return EVIDENCE / f"{self.name}.json"

    @property
    def run(self) -> Callable[[int, int], Result]:
        """Return its function."""
        module, _, function = self.module.partition(":")
        where = module if module.startswith("tests.") else f"tests.benchmarks.{module}"
        return getattr(import_module(where), function or "proof")  # type: ignore[no-any-return]


def spread(function: Callable[[Item], Found], items: Iterable[Item], chunk: int = 1) -> list[Found]:
    """Return what a function makes of each item, in their order, by one process for each processor."""
    with ProcessPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return list(pool.map(function, items, chunksize=chunk))


def measure(proof: Proof, size: int, seed: int) -> dict[str, Any]:
    """Run a proof and return its evidence as a document."""
    began = time.perf_counter()
    result = proof.run(size, seed)
    return {
        "format": FORMAT,
        "name": proof.name,
        "shows": proof.shows,
        "commit": program_commit(),
        "date": datetime.now(UTC).date().isoformat(),
        "machine": {"cpu": cpu_model(), "cores": os.cpu_count(), "python": platform.python_version()},
        "size": {"value": size, "unit": proof.unit},
        "seed": seed,
        "command": f"python -m tests.proof {proof.name} --size {size} --seed {seed}",
        "seconds": round(time.perf_counter() - began, 1),
        "result": {name: _stated(figure) for name, figure in result.items()},
    }


def write(document: Mapping[str, Any], file: Path) -> None:
    """Write evidence, a line for each number."""
    file.parent.mkdir(exist_ok=True)
    file.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


def figures(document: Mapping[str, Any]) -> dict[str, Figure]:
    """Return the numbers of a document."""
    return {name: Figure(**stated) for name, stated in document["result"].items()}


def _stated(figure: Figure) -> dict[str, Any]:
    """Return a number, and what was asked, to four significant digits; without what was not asked."""
    known = {key: value for key, value in asdict(figure).items() if value not in {None, ""}}
    return {key: value if isinstance(value, str) else _rounded(float(value)) for key, value in known.items()}


def _rounded(value: float) -> float:
    return int(value) if value.is_integer() else float(f"{value:.4g}")


def program_commit() -> str:
    """Return the last commit that changed the program: it is the program that was measured, not its tests."""
    found = subprocess.run(
        ["git", "log", "-1", "--format=%h", "--", *PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return found.stdout.strip() or "unknown"


def cpu_model() -> str:
    """Return the name of the processor."""
    file = Path("/proc/cpuinfo")  # of Linux
    named = re.search(r"model name\s*: (.*)", file.read_text(encoding="utf-8")) if file.exists() else None
    return named[1] if named else platform.machine()
