"""Locate by a calibrated IMU: alignment, then GNSS velocity and IMU in a window, with a graph on it or without."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.fusion.alignment_attempts import align_when_possible, is_still
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, Waiting
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.pose_graph import OUTLIER_SIGMAS, GlobalPose, PoseGraphSettings
from procedures.fusion.preintegration import ImuGap, imu_gaps
from procedures.geodesy import earth_rate_n
from station.errors import DataRefused
from station.files.fusion_folder import FusionLog
from station.locate.outer_layer import (
    Alignment,
    Located,
    online,
    outer_settings,
    through_graph,
    trajectory_of,
    wheel_of,
    with_wheel,
)
from station.text import plural

STILL = 1e-3  # m/s, of a bench
BENCH_SPACING = 0.1  # s: poses at 10 Hz are promised


def by_imu(log: FusionLog, layers: int = 2) -> Located:
    """Locate by the IMU; layers 1: GNSS position in the same window, 2: in the outer graph."""
    if log.imu is None or log.noise is None:
        raise DataRefused(log.folder / "fusion.toml", None, "no [imu]", "one, for this source", "add it")
    given = outer_settings(log)
    earth_n = earth_rate_n(log.latitude)
    fixes = log.fixes.shifted(given.time_offset)
    has_velocity = bool(np.isfinite(fixes.v_n[:, :2]).all(axis=1).any())
    aligner = MovingAligner(log.noise, log.gravity, earth_n, given.arm, given.lever_arm_std, given.time_offset_std)
    aligned = align_when_possible(aligner, log.imu, fixes)
    if isinstance(aligned, Waiting):
        return never(aligned.why)
    still = is_still(log.imu, log.noise)
    layers = layers if has_velocity or still else 1  # nothing else would hold the velocity
    given = with_constants(given, aligned)
    site = Site(log.gravity, earth_n, log.noise)
    settings = WindowSettings(
        site, given.arm, layers, lever_std=given.lever_arm_std, offset_std=given.time_offset_std
    )
    if still:
        settings = replace(settings, still_std=STILL, spacing=BENCH_SPACING, lever_std=None, offset_std=None)
    wheel = None if still else wheel_of(log)
    window = InertialWindow(settings, log.imu, log.fixes.shifted(given.time_offset), aligned, wheel)
    if layers == 1:
        located = _one_layer(window, aligned.t)
    else:
        known = PoseGraphSettings(lever_arm=given.arm)  # what is estimated is the window's
        located = through_graph(log, window, after=aligned.t, settings=known, fixes=window.fixes)
    return replace(
        with_wheel(located, window),
        lever_arm=given.arm if given.lever_arm_std is None else located.lever_arm,
        time_offset=given.time_offset + (float(window.constants[3]) if given.time_offset_std else 0.0),
        warnings=(*located.warnings, *of_gaps(log, imu_gaps(log.imu))),
        alignment=alignment_of(aligned),
        gyro_bias=window.state.bg[-1],
        accel_bias=window.state.ba[-1],
    )


def _one_layer(window: InertialWindow, after: float) -> Located:
    """Run a window of one layer; no outlier is weighted down. Poses before ``after`` [s] are not online."""
    found = online(
        (GlobalPose(pose.t, pose.p_o, pose.C_ob, window.covariance_n) for pose in window.poses()), after
    )
    smoothed = trajectory_of([GlobalPose(t, p, C, np.zeros((4, 4))) for t, p, C in window.smoothed()])
    at = np.flatnonzero(window.frames.at >= 0)
    fix = window.frames.at[at]
    antenna = smoothed.p[at] + Rotation.from_quat(smoothed.q[at]).apply(window.constants[:3])
    off = np.linalg.norm(antenna - window.fixes.p_n[fix], axis=1) / window.fixes.position_std[fix]
    rejected = int(np.count_nonzero(off > OUTLIER_SIGMAS))
    return replace(found, smoothed=smoothed, rejected=rejected, layers=1, lever_arm=window.constants[:3])


def of_gaps(log: FusionLog, gaps: tuple[ImuGap, ...]) -> tuple[str, ...]:
    """Return what to say of gaps in the IMU's samples."""
    if not gaps or log.table.imu is None:
        return ()
    longest = max(gaps, key=lambda gap: gap.length)
    said = f"{plural(len(gaps), 'gap')}, the longest of {longest.length:.2f} s at {longest.first:.2f} s"
    return (f"{log.table.imu.file}: {said}; bridged by straight lines",)


def with_constants(given: PoseGraphSettings, aligned: AlignmentState) -> PoseGraphSettings:
    """Return the settings with lever arm and time offset as the alignment found them, where they are estimated.

    Their sigmas are as they were: from there on the same data are used again.
    """
    if aligned.lever is None:
        return given
    return replace(given, lever_arm=aligned.lever, time_offset=given.time_offset + aligned.time_offset)


def never(why: str) -> Located:
    """Return what there is where no alignment was found."""
    return replace(online(()), why_not=why)


def alignment_of(aligned: AlignmentState) -> Alignment:
    """Return an alignment in degrees: how far the IMU is turned about up once levelled, and its z from up.

    Levelling is the smallest rotation that takes body z to up, so that this holds for an IMU that stands on edge.
    """
    C_nb = aligned.C_now
    tilt = np.arccos(np.clip(C_nb[2, 2], -1, 1))
    yaw = 2 * np.arctan2(C_nb[1, 0] - C_nb[0, 1], 1 + np.trace(C_nb))  # of the twist about the vertical
    return Alignment(*np.degrees([yaw, aligned.yaw_std, tilt, aligned.tilt_std]).tolist())
