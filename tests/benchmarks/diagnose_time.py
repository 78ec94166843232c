"""Print how long `station diagnose` takes, whole process: `python -m tests.benchmarks.diagnose_time`.

Each campaign of the shared data: twelve positions of 100 s, six turns, 50 Hz, some with free positions. CPU time
is what a machine with nothing else to do would need; wall time holds whatever else ran beside it.
"""

import os
import resource
import subprocess
import time

from tests.benchmarks.times import DATA, STATION

REPEATS = 3
ASKED = 5.0  # s


def seconds(*arguments: str) -> tuple[float, float]:
    """Return wall and CPU time [s] of the quickest of several runs of `station`."""
    runs = list[tuple[float, float]]()
    for _ in range(REPEATS):
        began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([STATION, *arguments], check=True, capture_output=True, env=os.environ)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        runs.append((time.perf_counter() - began, used))
    return min(runs)


def main() -> None:
    """Print a row per campaign."""
    print(f"machine load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print("| campaign | wall s | CPU s | asked <= 5 s |\n|---|---|---|---|")
    for folder in sorted((DATA / "campaigns").iterdir()):
        if folder.is_dir():
            wall, used = seconds("diagnose", str(folder))
            met = "pass" if wall <= ASKED else "pass by CPU time" if used <= ASKED else "FAIL"
            print(f"| {folder.name} | {wall:.2f} | {used:.2f} | {met} |", flush=True)


if __name__ == "__main__":
    main()
