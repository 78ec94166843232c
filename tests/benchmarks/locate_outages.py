"""Print what outages of GNSS cost: `python -m tests.benchmarks.locate_outages DATA [PART ...] --seeds 3`.

DATA, GNSS and tracks as in `tests.benchmarks.locate` and `locate_vision`. Of each recording `BEFORE` to `AFTER` an
outage of 5, 10, 20 or 40 s are used, a place of its own for each seed, spread evenly; errors are those from
`LEAD` before it on. A part is `imu`, `odometry` or `camera` with the outage's length, as `imu-10`.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from procedures.fusion.alignment.alignment_attempts import between, fixes_between
from procedures.fusion.fusion_records import Trajectory
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.camera_source import by_vision
from station.locate.imu_source import by_imu
from station.locate.location_json import position_errors
from station.locate.odometry_source import by_odometry
from station.locate.result import Located
from tests.benchmarks.locate import INERTIAL, ODOMETRY, drawn, main, said
from tests.benchmarks.locate_vision import CAMERA
from tests.drivers.simulated.camera_tracks import View, simulate_tracks

LENGTHS = (5, 10, 20, 40)  # s
BEFORE, LEAD, AFTER = 25.0, 5.0, 10.0  # s
HEADS = "online mean, worst, smoothed mean, worst [m], fixes rejected"


def around(log: FusionLog, length: float, seed: int, seeds: int, is_seen: bool = False) -> tuple[FusionLog, float]:
    """Return a recording about an outage of ``length`` [s], GNSS drawn anew, and when the outage begins [s]."""
    assert log.truth is not None
    first, last = log.truth.t[0] + BEFORE, log.truth.t[-1] - length - AFTER
    begin = float(np.linspace(first, last, seeds + 2)[seed + 1])
    span = begin - BEFORE, begin + length + AFTER
    log = drawn(log, seed, gap=(begin, begin + length))
    assert log.truth is not None
    truth = _part(log.truth, *span)
    return replace(
        log, fixes=fixes_between(log.fixes, *span), truth=truth,
        imu=None if log.imu is None else between(log.imu, *span),
        odometry=None if log.odometry is None else _part(log.odometry, *span),
        tracks=simulate_tracks(truth, CAMERA, View(), seed) if is_seen else None, camera=CAMERA,
    ), begin  # fmt: skip


def _part(trajectory: Trajectory, first: float, last: float) -> Trajectory:
    k = (trajectory.t >= first) & (trajectory.t <= last)
    return Trajectory(trajectory.t[k], trajectory.p[k], trajectory.q[k])


def errors(log: FusionLog, located: Located, begin: float) -> list[float]:
    """Return online and smoothed mean and worst error [m] from `LEAD` before the outage on, and fixes rejected."""
    assert log.truth is not None
    found = list[float]()
    for part in (located.online, located.smoothed):
        off = position_errors(part, log.truth, begin - LEAD)
        assert off is not None, located.why_not
        found += [off.mean, off.worst]
    return [*found, float(located.rejected)]


def inertial(length: int, data: Path, seeds: int) -> None:
    """One layer and two, and the second over the first."""
    both = []
    for layers in (1, 2):
        rows = _rows(partial(by_imu, layers=layers), INERTIAL, f"imu, layers {layers}", length, data, seeds)
        both.append(np.median(rows, axis=0))
    print(f"imu, {length} s, two over one: {', '.join(f'{r:.2f}' for r in both[1][:4] / both[0][:4])}", flush=True)


def by_track(length: int, data: Path, seeds: int) -> None:
    """Somebody else's odometry, in the outer layer alone."""
    _rows(by_odometry, ODOMETRY, "odometry", length, data, seeds)


def camera(length: int, data: Path, seeds: int) -> None:
    """Camera, IMU and GNSS velocity in the inner layer."""
    _rows(by_vision, INERTIAL, "camera", length, data, seeds, is_seen=True)


def _rows(
    run: Callable[[FusionLog], Located], names: tuple[str, ...], what: str, length: int, data: Path, seeds: int,
    is_seen: bool = False,
) -> list[list[float]]:  # fmt: skip
    rows = list[list[float]]()
    for name in names:
        log = read_fusion(data / name)
        logs = [around(log, length, seed, seeds, is_seen) for seed in range(seeds)]
        rows += (here := [errors(one, run(one), begin) for one, begin in logs])
        said(f"{what}, {length} s {name}", here, HEADS)
    said(f"{what}, {length} s, all", rows, HEADS)
    return rows


KINDS: dict[str, Callable[[int, Path, int], None]] = {"imu": inertial, "odometry": by_track, "camera": camera}
PARTS: dict[str, Callable[[Path, int], None]] = {
    f"{kind}-{length}": partial(run, length) for kind, run in KINDS.items() for length in LENGTHS
}

if __name__ == "__main__":
    main(PARTS, __doc__)
