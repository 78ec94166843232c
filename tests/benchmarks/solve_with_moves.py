"""Print how long `station solve` takes with moves, whole process: `python -m tests.benchmarks.solve_with_moves`.

Twelve placings of 100 s, moves of 25 s between them, no turn, recorded as a guided campaign does (MCAP), at 50 Hz
and at 1 kHz. Asked: 3 s and 10 s of processor time, 1 GiB.
"""

import resource
import tempfile
from dataclasses import replace
from pathlib import Path

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from tests.benchmarks.times import seconds
from tests.station.campaign_writing import write_campaign

ASKED = ((0.02, 3.0), (0.001, 10.0))  # period [s], processor time [s]


def main() -> None:
    """Print a row per rate."""
    print("| Hz | processor time, s | asked | most memory, MB |\n|---|---|---|---|")
    for period, asked in ASKED:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "campaign"
            truth = replace(Truth.example(1), sample_period_s=period)
            write_campaign(folder, simulate_campaign(truth, 1, turns=(), moves=True), period, ".mcap")
            used = seconds("solve", str(folder))
        most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1000  # the larger comes last
        print(f"| {1 / period:.0f} | {used:.1f} | <= {asked:g} | {most:.0f} |", flush=True)


if __name__ == "__main__":
    main()
