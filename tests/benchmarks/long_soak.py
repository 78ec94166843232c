"""Print what `station diagnose` of a soak of 10^6 samples costs: `python -m tests.benchmarks.long_soak`.

One soak is quiet, in one a machine shakes three blocks of four, each channel at two frequencies of its own.
"""

import os
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from tests.benchmarks.times import STATION

SAMPLES, RATE_HZ, BLOCKS = 1_000_000, 50.0, 200
NOISE = np.repeat((1e-2, 5e-5), 3)  # deg/s, g
NAMES = "gx,gy,gz,ax,ay,az"
ASKED_S, ASKED_GIB = 20.0, 1.0
OPTIONS = (
    "--time", "time", "--gyro", "gx,gy,gz", "--accel", "ax,ay,az", "--unit-gyro", "deg/s", "--unit-accel", "g",
    "--temperature", "temp", "--as", "soak",
)  # fmt: skip


def written(file: Path, shaken: float) -> None:
    """Write a soak of which a share ``shaken`` of the blocks shakes."""
    rng = np.random.default_rng(5)
    t = np.arange(SAMPLES) / RATE_HZ
    values = rng.standard_normal((SAMPLES, 6)) * NOISE
    for part in np.array_split(np.arange(SAMPLES), BLOCKS):
        if rng.random() < shaken:
            for hertz in rng.uniform(2, 20, (2, 6)):
                values[part] += 8 * NOISE * np.sin(2 * np.pi * hertz * t[part, None])
    values[:, 5] += 1.0
    table = np.column_stack((t, values, 20 + 5 * np.sin(2 * np.pi * t / 7000)))
    np.savetxt(file, table, delimiter=",", header=f"time,{NAMES},temp", comments="", fmt="%.9g")


def main() -> None:
    """Print a row per soak."""
    print("| blocks that shake | CPU s | GiB | asked |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for shaken in (0.0, 0.75):
            written(file := Path(folder) / "soak.csv", shaken)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([STATION, "diagnose", str(file), *OPTIONS], check=True, capture_output=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            gib = after.ru_maxrss / 2**20
            met = "pass" if used <= ASKED_S and gib <= ASKED_GIB else "FAIL"
            print(f"| {shaken:.0%} | {used:.1f} | {gib:.2f} | {met}, load {os.getloadavg()[0]:.0f} |", flush=True)


if __name__ == "__main__":
    main()
