"""Print how well `station monitor --locate` knows place and heading: `python -m tests.benchmarks.locate_live`.

A simulated FOG in a vehicle: 20 s of rest, then bends at 6 to 10 m/s; a receiver whose fixes are 0.1 s late,
its own error 0.3 m for minutes, 0.05 m/s white. Medians and worst over the seeds, from 15 s after it was located.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.timed_faults import TimedFault
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from station.locate.location import Location
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DriveRig

SECONDS, STILL, SETTLED_S = 110.0, 20.0, 15.0
TRACK = bends(SECONDS, STILL)
OUTAGE = 65.0, 20.0  # s: when, how long


@dataclass(frozen=True)
class Run:
    """``begun`` [s] after setting off; errors of heading [deg], over sigma, of level place [m]; ms a second."""

    begun: float
    heading: FloatArray
    ratio: FloatArray
    place: FloatArray
    outliers: int
    cost: float


def drive(seed: int, hz: float, faults: list[TimedFault], arm: tuple[float, ...]) -> Run:
    truth = replace(
        Truth.example(seed), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0, gyro_turn_on_dph=1.0
    )
    rig = DriveRig(truth, TRACK, AutopilotTruth(position_std_m=0.3, default_hz=hz), faults, arm, seed=seed)
    began = time.process_time()
    rig.run(SECONDS - 2.0)
    cost = (time.process_time() - began) / SECONDS * 1e3
    found = [v.location for v in rig.lines if v.location is not None and v.location.is_located]
    late = [where for where in found if where.t > found[0].t + SETTLED_S]
    heading = np.array([turned(where) for where in late])
    std = np.array([where.heading_std or np.nan for where in late])
    place = np.array([off(where) for where in late])
    return Run(found[0].t - STILL, heading, heading / std, place, found[-1].outliers, cost)


def turned(where: Location) -> float:
    east, north, _ = TRACK.velocity(where.t)
    assert where.heading is not None
    return float((where.heading - np.degrees(np.arctan2(east, north)) + 180) % 360 - 180)


def off(where: Location) -> float:
    gone = TRACK.position(where.t) - TRACK.position(0.0)
    return float(np.linalg.norm(np.array(where.enu)[:2] - gone[:2]))


def jumps(seed: int) -> list[TimedFault]:
    """Return a tenth of the fixes off by 5 m, after setting off."""
    at = np.random.default_rng(seed).choice(np.arange(STILL + 15, SECONDS, 0.2), round((SECONDS - STILL - 15) / 2))
    return [TimedFault("jump", float(t), 0.2, 5.0) for t in sorted(at)]


CASES: dict[str, tuple[float, Callable[[int], list[TimedFault]], tuple[float, ...]]] = {
    "5 Hz": (5.0, lambda seed: [], (0.0, 0.0, 0.0)),
    "5 Hz, lever arm not given": (5.0, lambda seed: [], ()),
    "1 Hz": (1.0, lambda seed: [], (0.0, 0.0, 0.0)),
    "10 % of the fixes off by 5 m": (5.0, jumps, (0.0, 0.0, 0.0)),
    "20 s outage": (5.0, lambda seed: [TimedFault("no_fix", *OUTAGE)], (0.0, 0.0, 0.0)),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    seeds = parser.parse_args().seeds
    print(
        "case | located after s | heading rms, worst deg | over sigma rms | place rms, worst m | outliers | ms/s"
    )
    for name, (hz, faults, arm) in CASES.items():
        runs = [drive(seed, hz, faults(seed), arm) for seed in range(1, seeds + 1)]
        heading, ratio, place = (
            np.concatenate([getattr(r, n) for r in runs]) for n in ("heading", "ratio", "place")
        )
        print(
            f"{name} | {np.median([r.begun for r in runs]):.1f}, {max(r.begun for r in runs):.1f} | "
            f"{np.sqrt(np.mean(heading**2)):.3f}, {np.abs(heading).max():.2f} | "
            f"{np.sqrt(np.nanmean(ratio**2)):.2f} | "
            f"{np.sqrt(np.mean(place**2)):.2f}, {place.max():.2f} | {[r.outliers for r in runs]} | "
            f"{np.median([r.cost for r in runs]):.0f}"
        )


if __name__ == "__main__":
    main()
