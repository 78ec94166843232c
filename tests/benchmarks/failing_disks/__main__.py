"""Do jobs on a disk that fails or is slow; print a line of JSON of each: `failing_disks.tried` runs this."""

import argparse
import json
from pathlib import Path

from tests.benchmarks.failing_disks.slow_disk import SLOW_JOBS, tried_slow
from tests.benchmarks.failing_disks.trials import FAULTS, JOBS, tried


def main() -> None:
    """Print what came of it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("scratch", type=Path, help="where to work")
    parser.add_argument("--every", type=int, help="calls from one that fails to the next")
    parser.add_argument("--slow", type=float, metavar="S", help="only: a disk that takes so long for each change")
    parser.add_argument("--jobs", nargs="*", help="only these")
    asked = parser.parse_args()
    if asked.slow is not None:
        for job in asked.jobs or SLOW_JOBS:
            wrong = tried_slow(job, asked.scratch, asked.slow)
            print(json.dumps({"job": job, "wrong": dict.fromkeys(wrong, 1)}), flush=True)
        return
    for job in JOBS:
        for fault in FAULTS:
            found = tried(job, fault, asked.scratch, asked.every)
            result = {"calls": found.trials, "refused": found.refused, "wrong": found.wrong}
            print(json.dumps({"job": job, "fault": fault, **result}), flush=True)


if __name__ == "__main__":
    main()
