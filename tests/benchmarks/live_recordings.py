"""Print how a live location does on recordings of a real IMU: `python -m tests.benchmarks.live_recordings DATA`.

Samples in tenths of a second and fixes 0.1 s late go through what `station monitor --locate` runs; errors as of
`tests.benchmarks.locate`: nothing aligned, the first 15 s left out.
"""

import argparse
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.records import ImuNoise, ImuSeries
from procedures.geodesy import LocalLevel
from procedures.gnss import FixType, GnssFix, TimeMark
from station.fusion_folder import FusionLog, read_fusion
from station.locate.imu_noise import NoiseOf
from station.locate.live import LiveLocator
from station.locate.taken import Taken
from station.mcap_files.fix_reader import Record
from station.monitor.view import Location

FOLDERS = ("mh03_inertial", "v201_inertial", "v203_inertial", "v203_1hz", "mh03_outliers", "v201_outage")
LATE_S, TICK_S, WARM_UP_S = 0.1, 0.1, 15.0


class Stated(NoiseOf):
    """The densities that the folder states."""

    def __init__(self, noise: ImuNoise) -> None:
        self._noise = noise

    def __call__(self, imu: ImuSeries) -> ImuNoise | None:
        return self._noise


def records(log: FusionLog, origin: LocalLevel) -> Iterator[GnssFix]:
    fixes = log.fixes
    for i, t in enumerate(fixes.t.tolist()):
        latitude, longitude, height = origin.geodetic(fixes.p_n[i])
        east, north, up = fixes.v_n[i].tolist()
        std = float(fixes.position_std[i])
        yield GnssFix(
            "GPS_RAW_INT", 1, round((t + LATE_S) * 1e9), FixType.FIX_3D, device_ns=round(t * 1e9),
            latitude=latitude, longitude=longitude, height=height, speed=float(np.hypot(east, north)),
            course=float(np.arctan2(east, north) % (2 * np.pi)), v_up=up, horizontal_std=std, vertical_std=std,
            speed_std=float(fixes.velocity_std[i]),
        )  # fmt: skip


def place(origin: LocalLevel, location: Location) -> FloatArray:
    """Return where a location is in the folder's own frame, (3,) [m]."""
    return origin.enu(float(np.radians(location.latitude)), float(np.radians(location.longitude)), location.height)


def locate(folder: Path) -> None:
    log = read_fusion(folder)
    assert log.imu is not None
    assert log.noise is not None
    assert log.truth is not None
    origin, imu = LocalLevel(log.latitude, 0.1, 100.0), log.imu
    arm = log.table.gnss.lever_arm_m
    locator = LiveLocator(Stated(log.noise), np.array([1.0, 0, 0]), None if arm is None else np.array(arm))
    fixes = list(records(log, origin))
    found, began = list[tuple[float, FloatArray]](), time.process_time()
    edges = np.searchsorted(imu.t, np.arange(imu.t[0], imu.t[-1], TICK_S))
    for a, b in pairwise(edges.tolist()):
        now = float(imu.t[b - 1])
        new: list[Record] = [TimeMark(round(now * 1e9), round(now * 1e9), None)]
        while fixes and fixes[0].host_ns <= now * 1e9:
            new.append(fixes.pop(0))
        part = ImuSeries(imu.t[a:b], imu.omega_b[a:b], imu.f_b[a:b])
        locator.take(Taken(part, [(round(now * 1e9), now)], new))
        if locator.location.is_located:
            found.append((locator.location.t, place(origin, locator.location)))
    cost = (time.process_time() - began) / (imu.t[-1] - imu.t[0]) * 1e3
    t, p = np.array([at for at, _ in found]), np.array([where for _, where in found])
    truth = np.stack([np.interp(t, log.truth.t, log.truth.p[:, i]) for i in range(3)], axis=1)
    off = np.linalg.norm(p - truth, axis=1)[t > t[0] + WARM_UP_S]
    print(
        f"{folder.name:14} located at {t[0]:.1f} s, mean {off.mean():.4f} m, worst {off.max():.2f} m, "
        f"{locator.location.outliers} outliers, {cost:.0f} ms a second"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    for name in FOLDERS:
        locate(parser.parse_args().data / name)
