"""Locate by camera, IMU and GNSS velocity in a window, with the outer graph on it."""

from dataclasses import replace
from functools import partial

import numpy as np

from procedures.earth.geodesy import earth_rate_n
from procedures.fusion.alignment.alignment_attempts import align_when_possible
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState, Waiting
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.imu.gnss_velocity import LeverArm
from procedures.fusion.imu.imu_gaps import imu_gaps
from procedures.fusion.inner.inertial_terms import Site
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.outer.pose_graph import PoseGraph, PoseGraphSettings
from procedures.fusion.vision.feature_tracks import FeatureTracks
from procedures.fusion.visual_alignment.visual_alignment_attempts import VisualAligner, align_by_camera
from station.errors import DataRefused
from station.files.fusion_folder import FusionLog
from station.locate.camera_clock import on_imu_clock, suspected_offset
from station.locate.imu_source import alignment_of, never, of_gaps
from station.locate.outer_layer import outer_settings, through_graph
from station.locate.result import Located
from station.locate.wheel import wheel_of, with_wheel

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
    told = partial(_tell_lever, window) if given.layout.lever_arm else None
    located = through_graph(log, window, after=max(aligned.t, clocked.since), settings=given, told=told)
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


def _tell_lever(window: VisualInertialWindow, graph: PoseGraph) -> None:
    window.antenna = LeverArm(graph.constants[0], graph.lever_std)


def _aligned(
    log: FusionLog, tracks: FeatureTracks, settings: VisionSettings, fixes: GnssFixes
) -> AlignmentState | Waiting:
    """Align by the camera; where that never works by the IMU alone, as at rest."""
    assert log.imu is not None
    found = align_by_camera(VisualAligner(settings), log.imu, tracks, fixes)
    if not isinstance(found, Waiting):
        return found.aligned
    site, antenna = settings.site, settings.antenna
    aligner = MovingAligner(site.noise, site.gravity, site.earth_n, antenna.lever, antenna.std or None)
    other = align_when_possible(aligner, log.imu, fixes)
    if isinstance(other, AlignmentState):
        return other
    hint = suspected_offset(log) if STRANGE_CLOCK in found.why else ""
    return Waiting(f"{found.why}{hint and f' ({hint})'}; without the camera: {other.why}")
