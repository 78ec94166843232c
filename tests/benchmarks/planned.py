"""Minutes of the campaigns that are planned, beside today's cut short: ``python -m tests.benchmarks.planned``."""

import time

from procedures.planning.campaign_design import CampaignDesign, usual_design
from procedures.planning.design_sigmas import DesignSigmas
from procedures.planning.dwell_lengths import equal_lengths
from procedures.planning.least_time import least_time
from procedures.planning.wanted_sigmas import WantedSigmas, with_all_solved
from tests.procedures.planning.bench_of_moves import ARCSEC, accelerometer_bias, bench, gyroscopes, unit

ASKED = {
    "gyro bias 0.02 deg/h": gyroscopes(bias=0.02),
    "accelerometer bias 1e-7 g": accelerometer_bias(1e-7),
    "accelerometer bias 1e-6 g": accelerometer_bias(1e-6),
    "gyro k 2.2 ppm": gyroscopes(k=2.2e-6),
    "gyro k 2.2 ppm and E 1.8 arcsec": gyroscopes(k=2.2e-6, misalignment=1.8 * ARCSEC),
    "all of these but 1e-6 g": gyroscopes(2.2e-6, 1.8 * ARCSEC, 0.02).and_also(accelerometer_bias(1e-7)),
}


def main() -> None:
    """Print a table."""
    engine = bench(unit())
    usual = engine.of(usual_design())
    print(f"{'wanted':34s}placings  turns  minutes  usual plan cut short  processor s")
    for name, asked in ASKED.items():
        begin = time.process_time()
        found = least_time(engine, with_all_solved(asked, usual))
        spent = time.process_time() - begin
        n = len(found.design.positions)
        minutes = found.design.minutes(engine.steps.hands)
        turns = len(found.design.placings) - n
        cut = cut_short(engine, asked)
        met = "" if found.is_met else " not met"
        print(f"{name:34s} {n:7d} {turns:6d} {minutes:8.1f} {cut:>21s} {spent:12.1f}{met}")


def cut_short(engine: DesignSigmas, asked: WantedSigmas) -> str:
    """Return the minutes of today's plan, its moves not in the solve, whose dwells are as short as they may be."""
    found: CampaignDesign | None = equal_lengths(engine, asked, usual_design(moves=False))
    return "never" if found is None else f"{found.minutes(engine.steps.hands):.1f}"


if __name__ == "__main__":
    main()
