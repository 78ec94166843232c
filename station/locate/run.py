"""Locate a fusion folder: its source through the outer graph, each online pose timed."""

from collections.abc import Iterable
from time import perf_counter

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.odometry import OdometrySource, RecordedOdometry, without_restarts
from procedures.fusion.outer_graph import GlobalPose, OuterGraph, OuterSettings
from procedures.fusion.records import Trajectory
from station.errors import DataRefused
from station.fusion_folder import FusionLog
from station.locate.result import Alignment, Located

FREE_ARM = 1.0  # m, 1 sigma of a lever arm that is not given


def locate(log: FusionLog, source: str, layers: int = 2) -> Located:
    """Locate a folder by one of `SOURCES`.

    Raises
    ------
    DataRefused
        If the folder does not hold what the source needs.
    """
    return SOURCES[source](log, layers)


def default_source(log: FusionLog) -> str:
    """Return the source that is taken where none is asked for."""
    return "odometry" if log.odometry is not None else "inertial"


def by_odometry(log: FusionLog, _layers: int = 2) -> Located:
    """Locate by a recorded odometry."""
    if log.odometry is None or log.table.odometry is None:
        raise DataRefused(log.folder / "fusion.toml", None, "no [odometry]", "one, for this source", "add it")
    kept, dropped = without_restarts(log.odometry)
    if len(kept) < 2:
        file = log.folder / log.table.odometry.file
        raise DataRefused(file, None, "a restart at its end", "an odometry that goes on")
    said = f"{log.table.odometry.file}: {dropped} poses before a step that no motion explains were dropped"
    return through_graph(log, RecordedOdometry(kept), (said,) if dropped else ())


def through_graph(log: FusionLog, source: OdometrySource, warnings: tuple[str, ...] = ()) -> Located:
    """Locate by a source and the outer graph."""
    settings = outer_settings(log)
    graph = OuterGraph(settings)
    poses, seconds = timed(graph.run(source, log.fixes))
    smoothed, rejected = graph.smoothed()
    seen = graph.alignment
    lever, offset = graph.constants
    return Located(
        trajectory_of(poses), smoothed, graph.begun_at, graph.why_not, rejected, seconds,
        None if seen is None else Alignment(float(np.degrees(seen.yaw)), float(np.degrees(seen.std))),
        lever_arm=lever, time_offset=offset, warnings=warnings,
    )  # fmt: skip


def outer_settings(log: FusionLog) -> OuterSettings:
    """Return what the folder gives of lever arm and time offset; a lever arm that is not given is estimated."""
    gnss = log.table.gnss
    arm = None if gnss.lever_arm_m is None else np.array(gnss.lever_arm_m)
    arm_std = gnss.lever_arm_std_m or (FREE_ARM if arm is None else None)
    return OuterSettings(
        lever_arm=arm,
        lever_arm_std=arm_std,
        time_offset=gnss.time_offset_s or 0.0,
        time_offset_std=gnss.time_offset_std_s,
    )


def timed(poses: Iterable[GlobalPose]) -> tuple[list[GlobalPose], FloatArray]:
    """Return the poses, and how long each took [s]."""
    found, seconds = list[GlobalPose](), list[float]()
    start = perf_counter()
    for pose in poses:
        found.append(pose)
        seconds.append(perf_counter() - start)
        start = perf_counter()
    return found, np.array(seconds)


def trajectory_of(poses: list[GlobalPose]) -> Trajectory:
    """Return poses as one trajectory."""
    if not poses:
        return Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 4)))
    q = Rotation.from_matrix(np.array([pose.C_nb for pose in poses])).as_quat()
    return Trajectory(np.array([pose.t for pose in poses]), np.array([pose.p for pose in poses]), q)


SOURCES = {"odometry": by_odometry}
