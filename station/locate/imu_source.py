"""Locate by a calibrated IMU: alignment, then GNSS velocity and IMU in a window, with a graph on it or without."""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.fusion.alignment.alignment_at_rest import is_still
from procedures.fusion.alignment.alignment_attempts import align_when_possible
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState, Waiting
from procedures.fusion.imu.imu_gaps import ImuGap, imu_gaps
from procedures.fusion.inner.inertial_terms import Site
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.outer.pose_graph import PoseGraphSettings
from station.errors import DataRefused
from station.files.fusion_folder import FusionLog
from station.locate.inner_layer_only import one_layer
from station.locate.outer_layer import outer_settings, through_graph, trajectory_of
from station.locate.result import Alignment, Located
from station.text.plural import plural

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
    window = InertialWindow(settings, log.imu, log.fixes.shifted(given.time_offset), aligned)
    if layers == 1:
        located = one_layer(window, aligned)
    else:
        known = PoseGraphSettings(lever_arm=given.arm)  # what is estimated is the window's
        located = through_graph(log, window, after=aligned.t, settings=known, fixes=window.fixes)
    return replace(
        located,
        lever_arm=given.arm if given.lever_arm_std is None else located.lever_arm,
        time_offset=given.time_offset + (float(window.constants[3]) if given.time_offset_std else 0.0),
        warnings=(*located.warnings, *of_gaps(log, imu_gaps(log.imu))),
        alignment=alignment_of(aligned),
        gyro_bias=window.state.bg[-1],
        accel_bias=window.state.ba[-1],
    )


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
    nothing = trajectory_of([])
    return Located(nothing, nothing, None, why, 0, np.zeros(0))


def alignment_of(aligned: AlignmentState) -> Alignment:
    """Return an alignment in degrees."""
    yaw, tilt = yaw_and_tilt(aligned.C_now)
    return Alignment(yaw, float(np.degrees(aligned.yaw_std)), tilt, float(np.degrees(aligned.tilt_std)))


def yaw_and_tilt(C_nb: FloatArray) -> tuple[float, float]:
    """Return how far [deg] ``C_nb`` (3, 3) is turned about the vertical once levelled, and its z is from up.

    Levelling is the smallest rotation that takes body z to up, so that this holds for an IMU that stands on edge.
    """
    up_b = C_nb[2]
    tilt = float(np.arccos(np.clip(up_b[2], -1, 1)))
    q_w, q_z = 1 + np.trace(C_nb), C_nb[1, 0] - C_nb[0, 1]  # of the twist about the vertical
    return float(np.degrees(2 * np.arctan2(q_z, q_w))), float(np.degrees(tilt))
