"""A source through the outer graph, each online pose timed."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from time import perf_counter
from typing import Protocol, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes, Trajectory
from procedures.fusion.odometry import OdometrySource
from procedures.fusion.outer.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings
from station.files.fusion_folder import FusionLog
from station.locate.result import Alignment, Located

FREE_ARM = 1.0  # m, 1 sigma of a lever arm that is not given
T = TypeVar("T")


class Pose(Protocol):
    """Anything with a time [s], a position (3,) [m] and an attitude (3, 3)."""

    @property
    def t(self) -> float: ...  # noqa: D102
    @property
    def p(self) -> FloatArray:
        """The position (3,) [m]."""
        ...

    @property
    def C_nb(self) -> FloatArray:
        """The rotation (3, 3) from body to n."""
        ...


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
    poses, seconds = timed(_telling(run, graph, told))
    online = [k for k, pose in enumerate(poses) if pose.t >= after]
    smoothed, rejected = graph.smoothed()
    seen = graph.alignment
    lever, offset = graph.constants
    return Located(
        trajectory_of([poses[k] for k in online]), smoothed, poses[online[0]].t if online else None,
        graph.why_not, rejected, seconds[online],
        None if seen is None else Alignment(float(np.degrees(seen.yaw)), float(np.degrees(seen.std))),
        lever_arm=lever, time_offset=offset, warnings=warnings,
        covariance=np.array([poses[k].covariance for k in online]).reshape(-1, 4, 4),
    )  # fmt: skip


def _telling(
    poses: Iterable[GlobalPose], graph: PoseGraph, told: Callable[[PoseGraph], None] | None
) -> Iterator[GlobalPose]:
    for pose in poses:
        if told is not None:
            told(graph)
        yield pose


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


def timed(poses: Iterable[T]) -> tuple[list[T], FloatArray]:
    """Return the poses, and how long each took (n,) [s]."""
    found, seconds = list[T](), list[float]()
    start = perf_counter()
    for pose in poses:
        found.append(pose)
        seconds.append(perf_counter() - start)
        start = perf_counter()
    return found, np.array(seconds)


def trajectory_of(poses: Sequence[Pose]) -> Trajectory:
    """Return poses as one trajectory."""
    if not poses:
        return Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 4)))
    q = Rotation.from_matrix(np.array([pose.C_nb for pose in poses])).as_quat()
    return Trajectory(np.array([pose.t for pose in poses]), np.array([pose.p for pose in poses]), q)
