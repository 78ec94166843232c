"""A disk that takes long for each write, met by jobs of this process and by a program that records.

Each process below gets the shim and slows itself from its first call on. Nothing that was accepted may be lost, no
sample of the line be missing.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station.files.mcap_files import read_step
from station.files.sha256sums import verify_folder
from station.stream.recorder.plain_recording import RECORDING_FILE
from tests.benchmarks.failing_disks import SHIM
from tests.benchmarks.failing_disks.trials import JOBS, NAMES, SYNCS, WRITES, FailingDisk, Wrong
from tests.station.commands.program import STATION

RECORDED_S, PERIOD_S = 12.0, 0.01


def in_this_process(job: str) -> Callable[[Path, float], Wrong]:
    """Return a job of `trials` on a slow disk."""

    def do(home: Path, delay_s: float) -> Wrong:
        disk = FailingDisk(home)
        try:
            return JOBS[job](home, disk, lambda: disk.arm(WRITES | SYNCS | NAMES, 0, 0, delay_s=delay_s))
        finally:
            disk.heal()

    return do


def station(home: Path, delay_s: float, *arguments: object) -> tuple[int, str]:
    """Run a command, slow at each change of what lies below ``home``; return its exit code and its stderr."""
    slow = {"LD_PRELOAD": os.environ[SHIM], "SLOW_DISK_BELOW": str(home), "SLOW_DISK_S": str(delay_s)}
    command = [sys.executable, "-P", "-c", STATION, *map(str, arguments)]
    done = subprocess.run(command, env=os.environ | slow, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def record(home: Path, delay_s: float) -> Wrong:
    """Record a device that goes on sending; no sample lacks, and the recording of raw bytes is whole."""
    with SimulatedDevice(replace(Truth.example(5), sample_period_s=PERIOD_S), 5) as device:
        code, output = station(home, delay_s, "record", device.url, "--seconds", RECORDED_S, "--out", home / "r")
    wrong = [] if (code, output) == (0, "") else [f"record: code {code}, {output}"]
    for path in sorted((home / "r").glob("*.mcap")):
        step = read_step(path)
        wrong += [f"{path.name}: {step.damage}"] if step.damage else []
        if path.name == RECORDING_FILE:
            seconds = (step.device_ns[-1] - step.device_ns[0]) / 1e9 + PERIOD_S
            if (lacking := round(seconds / PERIOD_S) - len(step)) or seconds < RECORDED_S - PERIOD_S:
                wrong.append(f"{lacking} samples lack of {seconds:g} s")
    verify_folder(home / "r")
    return wrong


SLOW_JOBS: Mapping[str, Callable[[Path, float], Wrong]] = {
    "accept": in_this_process("accept"), "store": in_this_process("store"), "apply": in_this_process("apply"),
    "record": record,
}  # fmt: skip


def tried_slow(job: str, scratch: Path, delay_s: float) -> Wrong:
    """Do a job on a disk that takes ``delay_s`` for each change; return what was wrong."""
    home = scratch / job
    home.mkdir()
    try:
        return SLOW_JOBS[job](home, delay_s)
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
