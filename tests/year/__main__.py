"""`python -m tests.year --seed S --campaigns N`: `--campaign K` runs one again, with its log."""

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tests.year.night import Night, one_campaign


def main() -> int:
    """Run campaigns and print what was found; 1 where anything was."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--campaigns", type=int, default=10)
    parser.add_argument("--campaign", type=int, help="this one alone, with its log of events")
    parser.add_argument("--whole", action="store_true", help="the usual plan of 19 steps in every campaign")
    arguments = parser.parse_args()
    numbers = range(arguments.campaigns) if arguments.campaign is None else [arguments.campaign]
    night, began = Night(), time.process_time()
    for number in numbers:
        with tempfile.TemporaryDirectory(prefix="year-") as folder:
            outcome = one_campaign(Path(folder), arguments.seed, number, is_whole=arguments.whole)
        if arguments.campaign is not None:
            print("\n".join(outcome.log))
        night.take(outcome)
        print(outcome.line, flush=True)
    print(night.text(time.process_time() - began))
    return 1 if night.findings else 0


if __name__ == "__main__":
    sys.exit(main())
