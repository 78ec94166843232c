"""Print how far an exported C program and the library are apart: `python -m tests.benchmarks.exported_c`.

Random samples with every built-in effect that a program carries, compiled with every warning and sanitizer, beside
`station.calibration`; errors are parts of a vector's length.
The time of a sample is that of the program without sanitizers, at -O2, pipe included.
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

from tests.station.exports.c_and_station import MAGNETIC, apart, random_samples
from tests.station.exports.c_program import Program
from tests.station.exports.every_effect import every_effect


def main() -> None:
    """Compare float and double."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    samples = random_samples(asked.samples, asked.seed)
    print("| numbers | samples | force | rate | self-test | bytes of code | us a sample |")
    print("|---|---|---|---|---|---|---|")
    for name in ("double", "float"):
        with tempfile.TemporaryDirectory() as folder:
            found = apart(every_effect(), Path(folder), samples, is_float=name == "float")
            size, seconds = _bare(Path(folder), name == "float", asked.samples, asked.seed)
        print(
            f"| {name} | {asked.samples} | {found.force:.1e} | {found.rate:.1e} | "
            f"{found.self_test:.1e} | {size} | {seconds / asked.samples * 1e6:.2f} |"
        )


def _bare(folder: Path, is_float: bool, n: int, seed: int) -> tuple[int, float]:
    """Return the size of the object file's code and constants [bytes], and the time of n samples [s]."""
    import numpy as np

    subprocess.run(["cc", "-std=c99", "-O2", "-c", "fog_imu.c"], cwd=folder, check=True)
    sizes = subprocess.run(["size", "fog_imu.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    text = int(sizes.splitlines()[1].split()[0])
    subprocess.run(["cc", "-std=c99", "-O2", "fog_imu.o", "main.c", "-lm", "-o", "bare"], cwd=folder, check=True)
    program = Program(folder / "bare", np.float32 if is_float else np.float64, len(MAGNETIC))
    samples = random_samples(n, seed)
    begin = time.perf_counter()
    program.apply(samples.counts, samples.T, samples.dt, samples.field)
    return text, time.perf_counter() - begin


if __name__ == "__main__":
    main()
