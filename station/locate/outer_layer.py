"""A source through the outer graph, each online pose timed."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.fusion.fusion_records import GnssFixes, Trajectory
from procedures.fusion.odometry import OdometrySource
from procedures.fusion.outer.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings
from station.files.fusion_folder import FusionLog
from station.locate.result import Alignment, Located

FREE_ARM = 1.0  # m, 1 sigma of a lever arm that is not given


def through_graph(
    log: FusionLog, source: OdometrySource, warnings: tuple[str, ...] = (), after: float = -np.inf,
    settings: PoseGraphSettings | None = None, fixes: GnssFixes | None = None,
    told: Callable[[PoseGraph], None] | None = None,
) -> Located:  # fmt: skip
    """Locate by a source and the outer graph; poses before ``after`` [s] are not online.

    ``settings`` and ``fixes`` stand for what the folder gives; ``told`` is called after each pose.
    """
    graph = PoseGraph(settings or outer_settings(log))
    run = graph.run(source, log.fixes if fixes is None else fixes)
    found = online(run, after, None if told is None else partial(told, graph))
    smoothed, rejected = graph.smoothed()
    seen = graph.alignment
    lever, offset = graph.constants
    return replace(
        found, smoothed=smoothed, why_not=graph.why_not, rejected=rejected, lever_arm=lever, time_offset=offset,
        alignment=None if seen is None else Alignment(float(np.degrees(seen.yaw)), float(np.degrees(seen.std))),
        warnings=warnings,
    )  # fmt: skip


def outer_settings(log: FusionLog) -> PoseGraphSettings:
    """Return what the folder gives of lever arm and time offset; a lever arm that is not given is estimated."""
    gnss = log.table.gnss
    arm = None if gnss.lever_arm_m is None else np.array(gnss.lever_arm_m)
    arm_std = gnss.lever_arm_std_m or (FREE_ARM if arm is None else None)
    return PoseGraphSettings(
        lever_arm=arm,
        lever_arm_std=arm_std,
        time_offset=gnss.time_offset_s or 0.0,
        time_offset_std=gnss.time_offset_std_s,
    )


def online(poses: Iterable[GlobalPose], after: float = -np.inf, told: Callable[[], None] | None = None) -> Located:
    """Return the poses from ``after`` [s] on, and how long each took; ``told`` is called after each pose."""
    found, seconds = list[GlobalPose](), list[float]()
    start = perf_counter()
    for pose in poses:
        if told is not None:
            told()
        if pose.t >= after:
            found.append(pose)
            seconds.append(perf_counter() - start)
        start = perf_counter()
    return Located(
        trajectory_of(found), trajectory_of([]), found[0].t if found else None, "", 0, np.array(seconds),
        covariance=np.array([pose.covariance for pose in found]).reshape(-1, 4, 4),
    )  # fmt: skip


def trajectory_of(poses: Sequence[GlobalPose]) -> Trajectory:
    """Return poses as one trajectory."""
    if not poses:
        return Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 4)))
    q = Rotation.from_matrix(np.array([pose.C_nb for pose in poses])).as_quat()
    return Trajectory(np.array([pose.t for pose in poses]), np.array([pose.p for pose in poses]), q)
