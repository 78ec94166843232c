"""Let the disk fail at every call, or be slow: `python -m tests.benchmarks.failing_disks [--slow 5]` with gcc."""

import argparse
import os
import shutil
import sys
from pathlib import Path

from tests.benchmarks.failing_disks.failing_disk import SHIM, begun_anew, scratch_folder


def main() -> None:
    """Print what came of it; with the shim, where this process was begun without it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="calls from one that fails to the next")
    parser.add_argument("--slow", type=float, metavar="S", help="only: a disk that takes so long for each change")
    parser.add_argument("--jobs", nargs="*", help="only these")
    asked = parser.parse_args()
    scratch = scratch_folder()
    try:
        if SHIM not in os.environ:
            sys.exit(begun_anew(["-m", "tests.benchmarks.failing_disks", *sys.argv[1:]], scratch))
        trials(asked, scratch)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def trials(asked: argparse.Namespace, scratch: Path) -> None:
    """Print a row for each job and fault, and what was wrong."""
    # imported here: the process that only begins anew needs none of it
    from tests.benchmarks.failing_disks.slow_disk import SLOW_JOBS, tried_slow
    from tests.benchmarks.failing_disks.trials import FAULTS, JOBS, tried

    if asked.slow is not None:
        print(f"{'job':12} {'delay s':>8} {'took s':>8} {'wrong':>6}")
        for job in asked.jobs or SLOW_JOBS:
            slow = tried_slow(job, scratch, asked.slow)
            print(f"{job:12} {asked.slow:8g} {slow.seconds:8.0f} {len(slow.wrong):6}", flush=True)
            for text in slow.wrong[:8]:
                print(f"    WRONG {text}", flush=True)
        return
    print(f"{'job':8} {'fault':16} {'calls':>6} {'refused':>8} {'wrong':>6}")
    for job in asked.jobs or JOBS:
        for fault in FAULTS:
            found = tried(job, fault, scratch, asked.every)
            print(f"{job:8} {fault:16} {found.trials:6} {found.refused:8} {found.wrong.total():6}", flush=True)
            for text, number in found.wrong.most_common(8):
                print(f"    WRONG {number:4} {text}")


if __name__ == "__main__":
    main()
