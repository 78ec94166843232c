"""Hold still what a rearrangement must not move: `python -m tests.benchmarks.same_results FOLDER [--data DATA]`.

The first run keeps solutions, diagnoses, budgets, attitudes and trajectories in FOLDER/before: of the shared data
and of ten simulated campaigns, which it writes into FOLDER/campaigns. Each later run makes them again in
FOLDER/after and compares to the last digit; it prints what differs, by how much, and exits 1. What says when,
where and by which software a result was made does not count, nor how long it took.
"""

import argparse
import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from drivers.simulated.truth import Truth
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.results.diagnosis.closed_loop import close_loop
from tests.benchmarks.diagnosing.designs import DESIGNS, unit
from tests.paths import DATA
from tests.station.campaign_writing import write_campaign

PLANTED: tuple[tuple[str, dict[str, dict[str, float]]], ...] = (  # design, effects; ten campaigns
    ("plain", {}),
    ("plain", {"accelerometer.quadratic": {"x": 3e-5}}),
    ("plain", {"gyroscope.g_sensitivity": {"xy": 0.5}}),
    ("plain", {"accelerometer.relaxation": {"z": 2e-5}}),
    ("certified", {}),
    ("certified", {"accelerometer.quadratic": {"y": 3e-5}}),
    ("free", {"accelerometer.cross_product": {"xyz": 3e-5}}),
    ("warm", {"gyroscope.bias_temperature": {"x": 0.3}}),
    ("two speeds", {"gyroscope.scale_nonlinearity": {"z": 20.0}}),
    ("timed", {"clock.rate": {"value": 300.0}}),
)
VOLATILE = frozenset({"created_utc", "software", "solve_ms", "files"})
SHOWN = 12  # differences of one result that are printed


def main() -> int:
    """Make all results, keep or compare them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--jobs", type=int, default=2)
    told = parser.parse_args()
    data, folder = told.data.resolve(), told.folder.resolve()
    before = folder / "before"
    out = folder / "after" if before.exists() else before
    out.mkdir(parents=True, exist_ok=True)
    _write_simulated(folder / "campaigns")
    tasks = list(_tasks(data, folder / "campaigns", out))
    with ProcessPoolExecutor(told.jobs) as pool:
        for name, code in zip((task[0] for task in tasks), pool.map(_made, tasks), strict=True):
            print(f"{name}: {code}", flush=True)
    return _compare(before, out) if out != before else 0


def _write_simulated(folder: Path) -> None:
    for number, (design, effects) in enumerate(PLANTED):
        if (folder / str(number)).exists():
            continue
        truth: Truth = unit(number, **DESIGNS[design].truth, effects=effects)
        campaigns = DESIGNS[design].make(truth, number, ())
        write_campaign(folder / str(number), campaigns[0], truth.sample_period_s)


Task = tuple[str, list[str], Path]


def _tasks(data: Path, simulated: Path, out: Path) -> Iterator[Task]:
    """Yield a name, the command's arguments (or one word for what no command writes) and where it goes."""
    kinds = [("campaigns", data / "campaigns"), ("measured", data / "measured"), ("simulated", simulated)]
    for kind, parent in kinds:
        for folder in sorted(parent.iterdir()):
            if not folder.is_dir():
                continue
            for command in ("solve", "diagnose"):
                path = out / f"{kind}-{folder.name}-{command}.json"
                yield path.stem, [command, str(folder), "--json", str(path)], path
            path = out / f"{kind}-{folder.name}-budget.json"
            yield path.stem, ["budget", str(folder)], path
    for log in sorted((data / "attitude").glob("*.csv")):
        for aid in ("none", "airspeed-filter", "gnss", "paper-filter"):
            path = out / f"attitude-{log.stem}-{aid}.csv"
            yield path.stem, ["attitude", str(log), "--aid", aid, "--out", str(path)], path
    for folder in sorted((data / "fusion").iterdir()):
        if folder.is_dir():
            path = out / f"locate-{folder.name}.tum"
            batch = str(path.with_suffix(".batch"))
            yield path.stem, ["locate", str(folder), "--out", str(path), "--batch", batch], path


def _made(task: Task) -> str:
    """Run one task in this process; return its exit code, and keep it beside what it wrote."""
    _, arguments, path = task
    with (
        open(os.devnull, "w") as nothing,
        contextlib.redirect_stdout(nothing),
        contextlib.redirect_stderr(nothing),
    ):
        code = _budget(Path(arguments[1]), path) if arguments[0] == "budget" else cli.run(arguments)
    path.with_name(path.name + ".exit").write_text(f"{code}\n")
    return f"exit {code}"


def _budget(folder: Path, path: Path) -> int:
    try:
        found = close_loop([read_campaign(folder)]).budgets()
    except Exception as error:  # what refuses is compared by the name of its refusal
        path.write_text(json.dumps(type(error).__name__))
        return 3
    path.write_text(json.dumps([asdict(one) for one in found], default=str))
    return 0


def _compare(before: Path, after: Path) -> int:
    names = sorted({p.name for p in before.iterdir()} | {p.name for p in after.iterdir()})
    different = [name for name in names if not _is_same(before / name, after / name)]
    print(f"{len(names) - len(different)} of {len(names)} the same" + "".join(f"\n  {n}" for n in different))
    return 1 if different else 0


def _is_same(before: Path, after: Path) -> bool:
    if not (before.exists() and after.exists()):
        print(f"{before.name}: only {'before' if before.exists() else 'after'}")
        return False
    read: Callable[[Path], Any] = (
        (lambda p: _steady(json.loads(p.read_text()))) if before.suffix == ".json" else Path.read_bytes
    )
    old, new = read(before), read(after)
    if old == new:
        return True
    if before.suffix == ".json":
        for line in list(_differences(old, new))[:SHOWN]:
            print(f"{before.name}{line}")
    return False


def _steady(value: Any) -> Any:
    """Drop what says when, where and by which software."""
    if isinstance(value, dict):
        return {key: _steady(one) for key, one in value.items() if key not in VOLATILE}
    return [_steady(one) for one in value] if isinstance(value, list) else value


def _differences(old: Any, new: Any, where: str = "") -> Iterator[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if old.get(key) != new.get(key):
                yield from _differences(old.get(key), new.get(key), f"{where}.{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, (a, b) in enumerate(zip(old, new, strict=True)):
            if a != b:
                yield from _differences(a, b, f"{where}[{i}]")
    elif isinstance(old, float) and isinstance(new, float):
        yield f"{where}: {old!r} -> {new!r}, relative {abs(new - old) / max(abs(old), 1e-300):.1e}"
    else:
        yield f"{where}: {old!r} -> {new!r}"


if __name__ == "__main__":
    sys.exit(main())
