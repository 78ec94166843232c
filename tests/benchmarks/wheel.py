"""A wheel beside IMU and GNSS: ``python -m tests.benchmarks.wheel [--seeds N] [--fog]``.

Simulated drives of 400 s through a town (tests/procedures/fusion/drives.py), 60 s of them without GNSS, with
two slips and a stop in it. Printed, as median / worst of the seeds: the largest error in the outage without a
wheel, with one, and with one that never slips; what the scale factor is off and by how many of its sigmas; of the
time that it slipped how much was seen, and how much else was taken for a slip.
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from procedures.arrays import interpolated
from procedures.fusion.fusion_records import Trajectory
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.imu_source import by_imu
from station.locate.result import Located, WheelFound
from tests.benchmarks.locate import said
from tests.procedures.fusion.drives import FOG, MEMS, OUTAGE, SCALE, SLIPS, Drive
from tests.station.files.fusion_folder.drive_folders import write_drive

SETTLED_S = 1.0  # after the outage, in which its end still shows


def worst_in_outage(found: Trajectory, truth: Trajectory) -> float:
    """Return the largest error [m] in the outage."""
    k = (found.t > OUTAGE[0]) & (found.t < OUTAGE[1])
    return float(np.linalg.norm(found.p[k] - interpolated(found.t[k], truth.t, truth.p), axis=1).max())


def mean_error(located: Located, truth: Trajectory) -> float:
    """Return the mean error [m] of all online poses outside the outage."""
    found = located.online
    k = ((found.t < OUTAGE[0]) | (found.t > OUTAGE[1] + SETTLED_S)) & (found.t > 20.0) & (found.t < truth.t[-1])
    return float(np.linalg.norm(found.p[k] - interpolated(found.t[k], truth.t, truth.p), axis=1).mean())


def slips_seen(wheel: WheelFound) -> tuple[float, float]:
    """Return the part of the time of slips that was seen, and the seconds of what was none [s]."""
    t = np.arange(0.0, 400.0, 0.01)
    slipped, seen = (
        np.any([(t > begin) & (t < end) for begin, end, *_ in spans], axis=0) for spans in (SLIPS, wheel.slips)
    )
    return float((slipped & seen).sum() / slipped.sum()), float((seen & ~slipped).sum() * 0.01)


def run(seed: int, noise_is_fog: bool, layers: int) -> list[float]:
    """Return the figures of one drive."""
    drive = Drive(noise=FOG if noise_is_fog else MEMS)
    with tempfile.TemporaryDirectory() as folder:
        logs = [read_fusion(write_drive(Path(folder) / "a", drive, seed))]
        logs.append(read_fusion(write_drive(Path(folder) / "b", replace(drive, slips=()), seed)))
    with_it, unslipped = (by_imu(log, layers) for log in logs)
    without = by_imu(_without(logs[0]), layers)
    truth, wheel = logs[0].truth, with_it.wheel
    assert truth is not None
    assert wheel is not None
    errors = [worst_in_outage(each.online, truth) for each in (without, with_it, unslipped)]
    smoothed = [worst_in_outage(each.smoothed, truth) for each in (without, with_it)]
    off = abs(wheel.scale - SCALE)
    plain = [mean_error(each, truth) for each in (without, with_it)]
    found = [*errors, *smoothed, *plain, off * 1e4, off / wheel.scale_std, *slips_seen(wheel), wheel.rest_s]
    print("  " + " ".join(f"{value:.3f}" for value in found), flush=True)
    return found


def _without(log: FusionLog) -> FusionLog:
    return replace(log, wheel=None)


HEADS = (
    "outage, worst online: no wheel, wheel, one that never slips; smoothed: no wheel, wheel [m]; elsewhere mean: "
    "no wheel, wheel [m]; scale off [1e-4], over its sigma; of slips seen, taken for slips [s]; at rest [s]"
)

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--fog", action="store_true")
    parser.add_argument("--layers", type=int, nargs="*", default=[1, 2])
    asked = parser.parse_args()
    for layers in asked.layers:
        rows = [run(seed, asked.fog, layers) for seed in range(asked.seeds)]
        said(f"{'FOG' if asked.fog else 'MEMS'}, layers {layers}", rows, HEADS)
