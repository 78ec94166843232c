"""Print how much sooner two workers re-solve a fleet than one: `python -m tests.benchmarks.resolve`.

Simulated campaigns, each of another unit, solved again by the whole command `station resolve`, as one process and
as two local Dask workers in turn. On a machine with other work (see the load) the clock says little.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from station.results.cluster.engine import open_engine
from station.results.cluster.restartable_map import map_restartable
from tests.benchmarks import resolve as this  # workers cannot import what was started as __main__
from tests.station.campaign_writing import write_campaign

STATION = Path(sys.executable).with_name("station")
ASKED = 1.8


def record(item: tuple[str, int, float]) -> dict[str, Any]:
    """Simulate and write a campaign of dwells of some seconds."""
    folder, seed, dwell_s = item
    truth = Truth.example(seed)
    write_campaign(Path(folder), simulate_campaign(truth, seed, dwell_s=dwell_s), truth.sample_period_s)
    return {}


def fleet(root: Path, campaigns: int, dwell_s: float) -> list[str]:
    """Record a fleet; return its folders."""
    items = [(str(root / f"campaign_{seed:04d}"), seed, dwell_s) for seed in range(campaigns)]
    with open_engine() as engine:
        for done in map_restartable(this.record, items, list, None, engine):
            if done.answer.fault is not None:
                raise SystemExit(done.answer.fault.text)
    return [folder for folder, _, _ in items]


def seconds(folders: list[str], workers: int) -> float:
    """Return the time that the command takes [s]."""
    with tempfile.TemporaryDirectory() as out:
        command = [STATION, "resolve", *folders, "--workers", str(workers), "--out", out, "--db", f"{out}/s.db"]
        began = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        return time.perf_counter() - began


def main() -> None:
    """Print a line for each run and the ratio of the best."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=200)
    parser.add_argument("--dwell-s", type=float, default=100.0)
    parser.add_argument("--repeats", type=int, default=2)
    options = parser.parse_args()
    best: dict[int, float] = {}
    with tempfile.TemporaryDirectory() as root:
        folders = fleet(Path(root), options.campaigns, options.dwell_s)
        for _ in range(options.repeats):
            for workers in (1, 2):
                clock = seconds(folders, workers)
                print(f"{workers} workers: {clock:6.2f} s, load {os.getloadavg()[0]:.1f}", flush=True)
                best[workers] = min(best.get(workers, clock), clock)
    ratio = best[1] / best[2]
    print(f"{options.campaigns} campaigns: two workers {ratio:.2f} times as fast as one (asked {ASKED})")


if __name__ == "__main__":
    main()
