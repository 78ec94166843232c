"""Let the disk fail at every call of a job, or be slow: by a shim in C, in a process that begins with it."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from tests.paths import ROOT, disk_in_memory
from tests.proof.evidence import Figure, zero

SOURCE = Path(__file__).with_name("failing_calls.c")
SHIM = "FAILING_DISK_SHIM"


def proof_failing(size: int, seed: int) -> dict[str, Figure]:
    """Let each ``size``-th call of each job fail, in five manners."""
    rows = tried("--every", str(size))
    return {
        "calls that failed": Figure(sum(row["calls"] for row in rows)),
        "refused in one line": Figure(sum(row["refused"] for row in rows)),
        "wrong": zero(sum(sum(row["wrong"].values()) for row in rows)),
    }


def proof_slow(size: int, seed: int) -> dict[str, Figure]:
    """Let each change of the disk take ``size`` hundredths of a second."""
    return {f"{row['job']}: wrong": zero(len(row["wrong"])) for row in tried("--slow", str(size / 100))}


def tried(*asked: str) -> list[dict[str, Any]]:
    """Return what `__main__` says of each job, run with the shim; ``wrong``: how often each of what was wrong."""
    with disk_in_memory() as scratch:
        shim = scratch / "failing_calls.so"
        subprocess.run(["gcc", "-shared", "-fPIC", "-O1", "-o", str(shim), str(SOURCE), "-ldl"], check=True)
        command = [sys.executable, "-m", "tests.benchmarks.failing_disks", str(scratch), *asked]
        environment = {**os.environ, "LD_PRELOAD": str(shim), SHIM: str(shim)}
        done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    sys.stderr.writelines(
        f"{row['job']}: {number} times {text}\n" for row in rows for text, number in row["wrong"].items()
    )
    return rows
