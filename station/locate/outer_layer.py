"""A source through the outer pose graph, each online pose timed; the result of a folder; the wheel's aid."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes, Trajectory
from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.odometry import OdometrySource
from procedures.fusion.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings
from station.files.fusion_folder import FusionLog
from station.files.fusion_folder.fusion_tables import mount_of


@dataclass(frozen=True, slots=True)
class Alignment:
    """How the source's frame was found to stand against n at the start; degrees, what is not known is None."""

    yaw_deg: float
    yaw_std_deg: float
    tilt_deg: float | None = None
    tilt_std_deg: float | None = None


@dataclass(frozen=True, slots=True)
class WheelFound:
    """A wheel's scale factor with 1 sigma, when it slipped (from, to) [s], and how long the vehicle stood [s]."""

    scale: float
    scale_std: float
    slips: tuple[tuple[float, float], ...]
    rest_s: float


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """``online``: each pose uses nothing later; ``smoothed``: all poses by all fixes.

    ``covariance`` (n, 4, 4) is that of the online poses: position [m] and heading [rad] in n.
    ``begun_at`` [s] is None where it never could, and ``why_not`` says why. ``seconds`` (n,): how long each online
    pose took. ``layers`` is what was used, ``rejected`` of ``fixes`` stand
    off the smoothed trajectory. Biases and ``time_offset`` are the last; what was neither given nor
    estimated is None. ``camera_time_offset`` [s] is that of the camera's stamps, with 1 sigma where it was
    estimated.
    """

    online: Trajectory
    smoothed: Trajectory
    begun_at: float | None
    why_not: str
    rejected: int
    seconds: FloatArray
    alignment: Alignment | None = None
    gyro_bias: FloatArray | None = None
    accel_bias: FloatArray | None = None
    lever_arm: FloatArray | None = None
    time_offset: float | None = None
    camera_time_offset: float | None = None
    camera_time_offset_std: float | None = None
    warnings: tuple[str, ...] = ()
    layers: int = 2
    covariance: FloatArray | None = None
    fixes: int = 0
    wheel: WheelFound | None = None


FREE_ARM = 1.0  # m, 1 sigma of a lever arm that is not given


def through_graph(
    log: FusionLog, source: OdometrySource, warnings: tuple[str, ...] = (), after: float = -np.inf,
    settings: PoseGraphSettings | None = None, fixes: GnssFixes | None = None,
    on_pose: Callable[[PoseGraph], None] | None = None,
) -> Located:  # fmt: skip
    """Locate by a source and the outer graph; poses before ``after`` [s] are not online.

    ``settings`` and ``fixes`` stand for what the folder gives; ``on_pose`` is called after each pose.
    """
    graph = PoseGraph(settings or outer_settings(log))
    run = graph.run(source, log.fixes if fixes is None else fixes)
    found = online(run, after, None if on_pose is None else partial(on_pose, graph))
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


def online(
    poses: Iterable[GlobalPose], after: float = -np.inf, on_pose: Callable[[], None] | None = None
) -> Located:
    """Return the poses from ``after`` [s] on, and how long each took; ``on_pose`` is called after each pose."""
    found, seconds = list[GlobalPose](), list[float]()
    start = perf_counter()
    for pose in poses:
        if on_pose is not None:
            on_pose()
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


def wheel_of(log: FusionLog) -> WheelAid | None:
    """Return what the wheel of a folder says; None where it has none."""
    if log.wheel is None or log.table.wheel is None or log.noise is None:
        return None
    return WheelAid(mount_of(log.table.wheel), log.wheel, log.noise)


def with_wheel(located: Located, window: InnerWindow) -> Located:
    """Return a result with what a window found of its wheel."""
    if (wheel := window.wheel) is None:
        return located
    found = WheelFound(1 + window.state.wheel, window.wheel_std, tuple(wheel.slips), wheel.rest_s)
    return replace(located, wheel=found)
