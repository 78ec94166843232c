"""Print how a live location does on recordings of a real IMU: `python -m tests.benchmarks.live_recordings DATA`.

Samples in tenths of a second and fixes 0.1 s late go through what `station monitor --locate` runs; errors as of
`tests.benchmarks.locate`: nothing aligned, the first 15 s left out. With a camera its tracks are those of
`tests.benchmarks.locate_vision`, stamped when they are read, 60 ms late, which nobody tells.
"""

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from drivers.camera import CameraImage
from procedures.arrays import FloatArray, interpolated
from procedures.earth.geodesy import LocalLevel
from procedures.earth.gnss_records import FixType, GnssFix, TimeMark
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.vision.feature_tracks import FeatureTracks
from station.files.fusion_folder import FusionLog, read_fusion
from station.files.mcap_files.fix_reader import Record
from station.locate.live_camera import LiveCamera
from station.locate.live_locator import LiveLocator
from station.locate.location import Location
from station.locate.monitor_interface import LocatorTick
from station.stream.camera.feature_following import FeaturePositions
from tests.benchmarks.locate import INERTIAL, OUTAGE
from tests.benchmarks.locate_vision import seen

FOLDERS = ("mh03_inertial", "v201_inertial", "v203_inertial", "v203_1hz", "mh03_outliers", "v201_outage")
LATE_S, SEEN_LATE_S, TICK_S, WARM_UP_S = 0.1, 0.06, 0.1, 15.0


class Tracked:
    """A camera of which tracks are there already: `station.stream.camera.feature_following.Follow`."""

    def __init__(self, tracks: FeatureTracks) -> None:
        self._tracks = tracks
        self._t, self._begin = tracks.frames()
        self.images = [
            CameraImage(round((t + SEEN_LATE_S) * 1e9), None, str(i).encode()) for i, t in enumerate(self._t)
        ]

    def __call__(self, image: CameraImage) -> FeaturePositions:
        i = int(image.jpeg)
        rows = slice(int(self._begin[i]), int(self._begin[i + 1]))
        return self._tracks.feature[rows], self._tracks.uv[rows]


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


def locate(log: FusionLog, name: str) -> None:
    assert log.imu is not None
    assert log.noise is not None
    assert log.truth is not None
    origin, imu = LocalLevel(log.latitude, 0.1, 100.0), log.imu
    arm = log.table.gnss.lever_arm_m
    follow = None if log.tracks is None else Tracked(log.tracks)
    camera = None if follow is None or log.camera is None else LiveCamera(log.camera, follow)
    lever = None if arm is None else np.array(arm)
    locator = LiveLocator(lambda _: log.noise, np.array([1.0, 0, 0]), lever, camera)
    fixes, images = list(records(log, origin)), [] if follow is None else list(follow.images)
    found, began = list[tuple[float, FloatArray]](), time.process_time()
    edges = np.searchsorted(imu.t, np.arange(imu.t[0], imu.t[-1], TICK_S))
    for a, b in pairwise(edges.tolist()):
        now = float(imu.t[b - 1])
        new: list[Record] = [TimeMark(round(now * 1e9), round(now * 1e9), None)]
        while fixes and fixes[0].host_ns <= now * 1e9:
            new.append(fixes.pop(0))
        part = ImuSeries(imu.t[a:b], imu.omega_b[a:b], imu.f_b[a:b])
        come = [image for image in images if image.host_ns <= now * 1e9]
        images = images[len(come) :]
        locator.take(LocatorTick(part, [(round(now * 1e9), now)], new, come))
        if locator.location.is_located:
            found.append((locator.location.t, place(origin, locator.location)))
    cost = (time.process_time() - began) / (imu.t[-1] - imu.t[0]) * 1e3
    t, p = np.array([at for at, _ in found]), np.array([where for _, where in found])
    truth = interpolated(t, log.truth.t, log.truth.p)
    off = np.linalg.norm(p - truth, axis=1)[t > t[0] + WARM_UP_S]
    print(
        f"{name:14} located at {t[0]:.1f} s, mean {off.mean():.4f} m, worst {off.max():.2f} m, "
        f"{locator.location.outliers} outliers, {cost:.0f} ms a second {locator.location.camera}"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    data = parser.parse_args().data
    for each in FOLDERS:
        locate(replace(read_fusion(data / each), tracks=None), each)
    for each in (*INERTIAL, "v201_outage"):
        locate(seen(data, each, 1, OUTAGE if each == "v201_outage" else None), f"{each}, camera")
