"""Locate by camera, IMU and GNSS velocity in a window, with the outer graph; the camera clock's offset."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from procedures.fusion.alignment_attempts import align_when_possible, between
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries, Waiting
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.pose_graph import PoseGraph, PoseGraphSettings
from procedures.fusion.preintegration import imu_gaps
from procedures.fusion.vision.camera_time import CameraTimeOffset, camera_offset
from procedures.fusion.vision.visual_alignment import align_by_camera
from procedures.geodesy import earth_rate_n
from station.errors import DataRefused
from station.files.fusion_folder import FusionLog
from station.locate.imu_source import alignment_of, never, of_gaps
from station.locate.outer_layer import Located, outer_settings, through_graph, wheel_of, with_wheel

FIRST_ATTEMPT_S = 5.0  # s of tracks after which it is worth a try
ATTEMPT_INTERVAL_S = 1.0  # s between attempts
MIN_OFFSET_STD_S = 0.001  # s, standard uncertainty with which the window continues
UNKNOWN_OFFSET_STD_S = 0.01  # s, 1 sigma of a clock of which nothing was stated
WINDOW_S = 20.0  # s that are looked at
SUSPECTED_OFFSET_STD_S = 0.1  # s, 1 sigma about 0, within which such a clock is looked for
SIGNIFICANT_SIGMAS = 5.0  # sigmas from which an offset is one
HARMLESS_OFFSET_S = 0.005  # s, that a window hardly feels: docs/how-to/locate-vision.md


@dataclass(frozen=True, slots=True, eq=False)
class ClockedTracks:
    """Tracks on the IMU's clock: ``offset`` [s] was added, known ``since``; 1 sigma ``std`` [s], 0 if given."""

    tracks: FeatureTracks
    offset: float
    std: float
    since: float = -np.inf


def on_imu_clock(log: FusionLog) -> ClockedTracks | Waiting:
    """Shift a folder's tracks by the offset that is stated, or estimated where ``time_offset_std_s`` asks for it.

    What is found uses nothing later than ``since``. The window refines what is not given.
    """
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    stated, std = _stated_offset(log)
    if std is None:
        return ClockedTracks(
            log.tracks.shifted(stated or 0.0), stated or 0.0, UNKNOWN_OFFSET_STD_S if stated is None else 0.0
        )
    why = Waiting(f"IMU and camera overlap for less than {FIRST_ATTEMPT_S:g} s")
    start, end = (pick(log.imu.t[at], log.tracks.t[at]) for pick, at in ((max, 0), (min, -1)))
    for now in np.arange(start + FIRST_ATTEMPT_S, end, ATTEMPT_INTERVAL_S):
        found = _attempt(log, log.imu, log.tracks, float(now), stated or 0.0, std)
        if isinstance(found, CameraTimeOffset):
            found_std = max(found.std, MIN_OFFSET_STD_S)
            return ClockedTracks(log.tracks.shifted(found.offset), found.offset, found_std, float(now))
        why = found
    return why


def suspected_offset(log: FusionLog) -> str:
    """Return the offset of a camera's clock by the first turns that determine it, or nothing."""
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    if _stated_offset(log) != (None, None):
        return ""
    for now in np.arange(log.tracks.t[0] + WINDOW_S, log.tracks.t[-1] + WINDOW_S, WINDOW_S):
        found = _attempt(log, log.imu, log.tracks, float(now), 0.0, SUSPECTED_OFFSET_STD_S)
        if isinstance(found, CameraTimeOffset):
            if abs(found.offset) < max(SIGNIFICANT_SIGMAS * found.std, HARMLESS_OFFSET_S):
                return ""
            text = f"{found.offset * 1e3:.1f} +- {found.std * 1e3:.1f} ms"
            return f"the camera's time stamps seem to be wrong by {text}: state time_offset_s in [tracks]"
    return ""


def _stated_offset(log: FusionLog) -> tuple[float | None, float | None]:
    """Return ``time_offset_s`` and ``time_offset_std_s`` of ``[tracks]`` [s]."""
    table = log.table.tracks
    return (None, None) if table is None else (table.time_offset_s, table.time_offset_std_s)


def _attempt(
    log: FusionLog, imu: ImuSeries, tracks: FeatureTracks, now: float, about: float, std: float
) -> CameraTimeOffset | Waiting:
    """Try with the last data before ``now`` [s]."""
    assert log.camera is not None
    rows = slice(*np.searchsorted(tracks.t, (now - WINDOW_S, now)).tolist())
    part = FeatureTracks(tracks.t[rows], tracks.feature[rows], tracks.uv[rows])
    return camera_offset(between(imu, now - WINDOW_S - abs(about) - 1.0, now), part, log.camera, about, std)


STRANGE_CLOCK = "do not fit each other"  # what an alignment says whose camera may be late


def by_vision(log: FusionLog, _layers: int = 2) -> Located:
    """Locate by tracks, IMU and GNSS velocity."""
    for part, name in ((log.imu, "imu"), (log.tracks, "tracks")):
        if part is None:
            raise DataRefused(log.folder / "fusion.toml", None, f"no [{name}]", "one, for this source", "add it")
    assert log.imu is not None and log.noise is not None  # noqa: PT018
    assert log.tracks is not None and log.camera is not None  # noqa: PT018
    given = outer_settings(log)
    site = Site(log.gravity, earth_rate_n(log.latitude), log.noise)
    settings = VisionSettings(site, log.camera, antenna_of(given))
    fixes = log.fixes.shifted(given.time_offset)
    clocked = on_imu_clock(log)
    if isinstance(clocked, Waiting):
        return never(f"the camera's time offset: {clocked.why}")
    aligned = _aligned(log, clocked.tracks, settings, fixes)
    if isinstance(aligned, Waiting):
        return never(aligned.why)
    given = with_lever(given, aligned)
    settings = replace(settings, antenna=antenna_of(given), offset_std=clocked.std)
    window = VisualInertialWindow(settings, log.imu, clocked.tracks, fixes, aligned, wheel_of(log))
    on_pose = partial(_report_lever, window) if given.layout.lever_arm else None
    located = through_graph(log, window, after=max(aligned.t, clocked.since), settings=given, on_pose=on_pose)
    bias = {"gyro_bias": window.state.bg[-1], "accel_bias": window.state.ba[-1]}
    late = suspected_offset(log)
    warnings = (*located.warnings, *of_gaps(log, imu_gaps(log.imu)), *([late] if late else []))
    located = with_wheel(replace(located, alignment=alignment_of(aligned), warnings=warnings, **bias), window)
    if located.begun_at is None:
        return replace(located, why_not="the camera's time offset was known at the end only")
    if not clocked.std:
        return replace(located, camera_time_offset=clocked.offset)
    offset = clocked.offset + window.state.offset
    return replace(located, camera_time_offset=offset, camera_time_offset_std=window.offset_std)


def with_lever(given: PoseGraphSettings, aligned: AlignmentState) -> PoseGraphSettings:
    """Return the settings with the lever arm as the alignment found it, where it did."""
    if aligned.lever is None or given.lever_arm_std is None:
        return given
    std = float(np.sqrt(np.linalg.eigvalsh(aligned.covariance[12:15, 12:15])[-1]))
    return replace(given, lever_arm=aligned.lever, lever_arm_std=std)


def antenna_of(given: PoseGraphSettings) -> LeverArm:
    """Return the lever arm to begin with."""
    return LeverArm(given.arm, given.lever_arm_std or 0.0)


def _report_lever(window: VisualInertialWindow, graph: PoseGraph) -> None:
    window.antenna = LeverArm(graph.constants[0], graph.lever_std)


def _aligned(
    log: FusionLog, tracks: FeatureTracks, settings: VisionSettings, fixes: GnssFixes
) -> AlignmentState | Waiting:
    """Align by the camera; where that never works by the IMU alone, as at rest."""
    assert log.imu is not None
    found = align_by_camera(settings, log.imu, tracks, fixes)
    if not isinstance(found, Waiting):
        return found.aligned
    site, antenna = settings.site, settings.antenna
    aligner = MovingAligner(site.noise, site.gravity, site.earth_n, antenna.lever, antenna.std or None)
    other = align_when_possible(aligner, log.imu, fixes)
    if isinstance(other, AlignmentState):
        return other
    hint = suspected_offset(log) if STRANGE_CLOCK in found.why else ""
    return Waiting(f"{found.why}{hint and f' ({hint})'}; without the camera: {other.why}")
