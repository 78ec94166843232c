"""Print what `station diagnose` says of public logs as their owners left them, each fed in one line.

`python -m tests.benchmarks.foreign_logs`: the shared data's `foreign` and `measured` (`STATION_DATA`), the binary
of a MIMU4444 board by the reader of `docs/logs.md`. The verdict, the error's rms without and with the findings,
the same on what was left out, and processor seconds.
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from station import cli
from station.results.diagnosis.diagnosis_text import shown_unit
from tests.paths import DATA, ROOT

LSB = ("--rate", "100", "--unit-gyro", "131/(deg/s)", "--unit-accel", "16384/g")
COLUMNS = ("--rate", "100", "--accel", "1,2,3", "--gyro", "4,5,6", "--unit-gyro", "rad/s")
MIMU = ("--rate", "62.5", "--accel", "acc1:1,acc1:2,acc1:3", "--gyro", "gyro1:1,gyro1:2,gyro1:3",
        "--unit-accel", "2048/g", "--unit-gyro", "16.4/(deg/s)")  # fmt: skip
LOGS: tuple[tuple[str, Sequence[str]], ...] = (
    ("foreign/thermal_sweep_accelerometer/log.csv", ()),
    *((f"foreign/mikoff_imu_calib/imu{i}.log", COLUMNS) for i in range(5)),
    ("foreign/tomisuarez_mpu6050/example_data_tinit_calc.csv", LSB),
    ("foreign/tomisuarez_mpu6050/example_data_calibration.csv", LSB),
    ("foreign/tomisuarez_mpu6050/imu_90_x_rot.csv", LSB),
    ("foreign/mimu4444_bcd/exp_1.bin", MIMU),
    ("measured/xsens_mti/sequence.csv", ()),
    ("measured/ln100_two_positions/x_up.csv", ("--as", "dwell:x_up", "--unit-gyro", "deg/s")),
    ("measured/fog_rate_temperature/rates.csv", ("--reference", "rate_ref_deg_s")),
)


def main() -> None:
    """Print a row for each log."""
    with tempfile.TemporaryDirectory() as folder:
        for name, options in LOGS:
            for line in rows(DATA / name, options, Path(folder)):
                print(line)


def rows(log: Path, options: Sequence[str], folder: Path) -> Iterator[str]:
    """Yield the lines to print of one log."""
    if not log.is_file():
        yield f"{log}: not there, set STATION_DATA"
        return
    log = converted(log, folder) if log.suffix == ".bin" else log
    out, said, begin = folder / "out.json", StringIO(), time.process_time()
    with redirect_stdout(said), redirect_stderr(said):
        code = cli.run(["diagnose", str(log), *options, "--json", str(out)])
    yield f"{log.parent.name}/{log.name} {' '.join(options)}: exit {code}, {time.process_time() - begin:.1f} s"
    if code:
        yield f"    {said.getvalue().splitlines()[-1]}"
        return
    found = json.loads(out.read_text())
    effects = [f"{one['effect']} ({one['confidence']})" for one in found["findings"]]
    yield f"    {found['verdict']}: {', '.join(effects) or 'nothing named'}"
    for error in found["error"]:
        scale, unit = shown_unit(error["unit"])
        values = [f"{error[key] * scale:.4g}" if key in error else "-" for key in KEYS]
        yield f"    {error['quantity']} [{unit}] {values[0]} -> {values[1]}, left out {values[2]} -> {values[3]}"
    for move in found.get("moves", [])[:3]:
        yield f"    move: turned {[round(angle, 2) for angle in move['turned_deg']]} deg"
    yield from (f"    {text}" for text in found.get("solution", found)["warnings"] if "nine numbers" in text)


KEYS = ("before", "after", "held_out_before", "held_out_after")


def converted(log: Path, folder: Path) -> Path:
    """Return a binary as the page's own reader converts it."""
    code = re.findall(r"```python\n(.*?)```", (ROOT / "docs/logs.md").read_text(), re.DOTALL)[0]
    made = folder / f"{log.stem}.npz"
    subprocess.run([sys.executable, "-c", code, str(log), str(made)], check=True)
    return made


if __name__ == "__main__":
    main()
