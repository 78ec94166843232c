"""Print the processor time that whole commands take: `python -m tests.benchmarks.times`."""

import resource
import subprocess
import sys
from pathlib import Path

from tests.paths import DATA

STATION = Path(sys.executable).with_name("station")
REPEATS = 5


def seconds(*arguments: str) -> float:
    """Return the processor time [s] of `station` with these arguments, the least of several runs."""
    best = float("inf")
    for _ in range(REPEATS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([STATION, *arguments], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        best = min(best, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return best


def main() -> None:
    """Print a line per command."""
    print(f"station --help       {seconds('--help'):5.2f} s   asked 0.5")
    clean = DATA / "campaigns/clean"
    if clean.exists():
        print(f"station solve clean  {seconds('solve', str(clean)):5.2f} s   asked 1.2")


if __name__ == "__main__":
    main()
