"""How fast `station apply` is on one core, and in how much memory: ``python -m tests.benchmarks.apply [SAMPLES]``.

Samples in a second of processor time, reading and writing included, of each pair of formats, with a calibration
without effects and with six; and the most memory of a process of its own, at two lengths.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.station.applying.inputs import E_A, E_G, EFFECTS, K_A, K_G, NAMES, document

PERIOD = 0.001
SIX = EFFECTS[:1] + EFFECTS[4:8] + EFFECTS[8:9]
PAIRS = (
    ("npz", "npz"), ("npz", "parquet"), ("parquet", "npz"), ("parquet", "parquet"), ("npz", "csv"), ("npz", "mat"),
    ("npz", "mcap"), ("npz", "ros2"), ("csv", "npz"),
)  # fmt: skip
SLOW = {"csv", "mcap", "ros2"}
LESS = 10  # of the samples, for formats that are slow


def write_inputs(folder: Path, samples: int) -> None:
    draw = np.random.default_rng(1)
    t = PERIOD * np.arange(1, samples + 1)
    f, omega = draw.normal([0.0, 0.1, 1.0], 0.2, (samples, 3)), draw.uniform(-120, 120, (samples, 3))
    counts = np.rint(np.hstack((K_G * (omega @ E_G.T), K_A * (f @ E_A.T))) * PERIOD)
    columns = {"t_s": t, **dict(zip(NAMES, counts.T, strict=True)), "temp_c": 28 + 8 * np.sin(t / 900)}
    np.savez(folder / "in.npz", **columns)
    import pyarrow
    import pyarrow.parquet as parquet

    parquet.write_table(pyarrow.table(columns), folder / "in.parquet")
    few = {name: column[: samples // LESS] for name, column in columns.items()}
    np.savez(folder / "few.npz", **few)
    np.savetxt(
        folder / "few.csv", np.column_stack([*few.values()]), "%.9g", ",", header=",".join(few), comments=""
    )


def run(source: Path, out: Path, known: Path) -> None:
    """Apply once to warm up, and once to be measured: print samples/s of processor time and MiB."""
    from station.applying.applying import apply_to
    from station.applying.opened_source import open_source
    from station.applying.output_request import OutputRequest
    from station.applying.progress import Progress
    from station.calibration import load
    from station.files.logs.log_columns import ToldColumns

    def once(path: Path) -> int:
        opened = open_source(path, ToldColumns(), None)
        return apply_to(opened, load(known), out, OutputRequest(), Progress(lambda _: None)).samples

    if out.suffix != ".ros2":
        once(source.with_name("warm.npz"))
    begin = time.process_time()
    samples = once(source)
    seconds = time.process_time() - begin
    status = Path("/proc/self/status").read_text(encoding="ascii")
    most = int(re.findall(r"VmHWM:\s*(\d+) kB", status)[0]) / 1024
    print(json.dumps([samples, samples / seconds, most]))


def measured(source: Path, out: Path, known: Path) -> tuple[int, float, float]:
    words = [sys.executable, "-m", "tests.benchmarks.apply", "--one", str(source), str(out), str(known)]
    said = subprocess.run(
        words, check=True, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"}
    )
    samples, rate, most = json.loads(said.stdout.splitlines()[-1])
    return samples, rate, most


def main() -> None:
    samples = int(float(sys.argv[1])) if len(sys.argv) > 1 else 4_000_000
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for effects, what in (((), "plain"), (SIX, "six")):
            (folder / f"{what}.json").write_text(json.dumps(document(*effects)))
        write_inputs(folder, 20_000)
        (folder / "in.npz").rename(folder / "warm.npz")
        print("| from | to | samples | without effects [samples/s] | with six [samples/s] | memory [MiB] |")
        print("|---|---|---|---|---|---|")
        for length in (samples, 4 * samples):
            write_inputs(folder, length)
            for source, out in PAIRS if length == samples else PAIRS[:4]:
                few = source in SLOW or out in SLOW
                path = folder / f"{'few' if few else 'in'}.{source}"
                rows = []
                for what in ("plain", "six"):
                    target = folder / f"{what}_out.{out}"
                    rows.append(measured(path, target, folder / f"{what}.json"))
                    subprocess.run(["rm", "-rf", str(target)], check=True)
                (count, plain, _), (_, six, most) = rows
                print(f"| {source} | {out} | {count:.3g} | {plain:.2e} | {six:.2e} | {most:.0f} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        run(*map(Path, sys.argv[2:5]))
    else:
        main()
