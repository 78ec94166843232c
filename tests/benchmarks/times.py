"""Print how long whole commands take: `python -m tests.benchmarks.times`."""

import subprocess
import sys
import time
from pathlib import Path

from tests.paths import DATA

STATION = Path(sys.executable).with_name("station")
REPEATS = 5


def seconds(*arguments: str) -> float:
    """Return the best of several runs of `station` with these arguments [s]."""
    best = float("inf")
    for _ in range(REPEATS):
        began = time.perf_counter()
        subprocess.run([STATION, *arguments], check=True, capture_output=True)
        best = min(best, time.perf_counter() - began)
    return best


def main() -> None:
    """Print a line per command."""
    print(f"station --help       {seconds('--help'):5.2f} s   asked 0.5")
    clean = DATA / "campaigns/clean"
    if clean.exists():
        print(f"station solve clean  {seconds('solve', str(clean)):5.2f} s   asked 1.5")


if __name__ == "__main__":
    main()
