"""Let the disk fail at every call of a job, or be slow: programs run with a shim in C, so that each is a child."""

import subprocess
import sys

from tests.paths import ROOT
from tests.proof.evidence import Figure, zero


def proof_failing(size: int, seed: int) -> dict[str, Figure]:
    """Let each ``size``-th call of each job fail, in five manners."""
    rows = _rows("--every", str(size))
    calls, refused, wrong = (sum(int(row[at]) for row in rows) for at in (-3, -2, -1))
    return {"calls that failed": Figure(calls), "refused in one line": Figure(refused), "wrong": zero(wrong)}


def proof_slow(size: int, seed: int) -> dict[str, Figure]:
    """Let each change of the disk take ``size`` hundredths of a second."""
    return {f"{row[0]}: wrong": zero(int(row[-1])) for row in _rows("--slow", str(size / 100))}


def _rows(*asked: str) -> list[list[str]]:
    command = [sys.executable, "-m", "tests.benchmarks.failing_disks", *asked]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()[1:]
    sys.stderr.writelines(f"{line}\n" for line in lines if "WRONG" in line)
    return [line.split() for line in lines if "WRONG" not in line]
