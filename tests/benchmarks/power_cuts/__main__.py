"""Cut the power at any moment, and look: `python -m tests.benchmarks.power_cuts --states 100000 --seed 1`."""

import argparse

from tests.benchmarks.power_cuts.trial import tried
from tests.benchmarks.power_cuts.workloads import WORKLOADS


def main() -> None:
    """Print a row for each workload, and what was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=1000, help="different states, over all workloads")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workloads", nargs="*", default=list(WORKLOADS))
    parser.add_argument("--told", action="store_true", help="also what the station says of the states")
    asked = parser.parse_args()
    print(f"{'workload':12} {'operations':>10} {'states':>7} {'kinds':>6} {'told':>6} {'wrong':>6} {'cpu s':>6}")
    states = 0
    for left, name in zip(range(len(asked.workloads), 0, -1), asked.workloads, strict=True):
        tally = tried(name, max(1, (asked.states - states) // left), asked.seed)  # what the short ones have not
        states += tally.states
        told, wrong = tally.told.total(), tally.wrong.total()
        counts = f"{tally.operations:10} {tally.states:7} {tally.kinds:6} {told:6} {wrong:6} {tally.seconds:6.0f}"
        print(f"{name:12} {counts}", flush=True)
        for text, number in tally.wrong.most_common(12):
            print(f"    WRONG {number:6} {text}   [{tally.first[text]}]")
        for text, number in tally.told.most_common(8) if asked.told else []:
            print(f"    told  {number:6} {text}")
    print(f"{states} different states")


if __name__ == "__main__":
    main()
