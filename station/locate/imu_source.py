"""Locate by a calibrated IMU: alignment, then GNSS velocity and IMU in a window, with a graph on it or without.

Noise densities are those of the Allan deviation of the IMU's own rest, and what its calibration reports. White
noise is the random walk of the curve, or the most that the curve allows; of the counting, which is not white, what
it makes of a second. A bias' random walk that the rest is too short to show is bounded by what a FOG's is.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude.sensor_noise import white_noise
from procedures.free_positions.rest_detection import second_means, whole_seconds
from procedures.fusion.alignment_attempts import align_when_possible, is_still
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, ImuNoise, ImuSeries, Waiting
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.pose_graph import OUTLIER_SIGMAS, GlobalPose, PoseGraphSettings
from procedures.fusion.preintegration import ImuGap, imu_gaps
from procedures.geodesy import earth_rate_n
from procedures.statistics.allan_deviation import fit_noise, overlapping_deviation
from station.calibrated.filter_settings import FORCE_WALK, GYRO_BIAS_WALK, force_bias_std, gyro_bias_std
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
    has_velocity = bool(fixes.has_velocity.any())
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
    text = f"{plural(len(gaps), 'gap')}, the longest of {longest.length:.2f} s at {longest.first:.2f} s"
    return (f"{log.table.imu.file}: {text}; bridged by straight lines",)


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


MIN_REST_S = 10.0  # of rest, for an Allan deviation
PATIENCE_S = 30.0
SAME_FORCE = 0.03  # m/s2 between the means of two seconds
SAME_RATE = np.radians(0.2)  # rad/s
MINUTE_S = 60.0
COUNTED_S = 1.0  # within which the counting's error is taken for white
MIN_GYRO_NOISE, MIN_FORCE_NOISE = 1e-7, 1e-4  # rad/s, m/s2 per root of a Hz: nothing is quieter on a vehicle
MIN_BIAS_WALK = 1e-10  # in either unit, below which the estimator's arithmetic ends


@dataclass(frozen=True, slots=True)
class Rest:
    """The samples from ``first`` to before ``last`` that stand still the longest, ``seconds`` of them."""

    first: int
    last: int
    seconds: float


def noise_once_known(
    imu: ImuSeries, period: float, calibration: Mapping[str, Any] | None, quantum: tuple[float, float]
) -> ImuNoise | None:
    """Return `noise_densities` after `MIN_REST_S` of rest, or for want of it after `PATIENCE_S`; None before."""
    rest, seconds = longest_rest(imu, quantum[1]), float(imu.t[-1] - imu.t[0])
    if rest.seconds < MIN_REST_S and seconds < PATIENCE_S:
        return None
    return noise_densities(imu, rest, period, calibration, quantum)


def longest_rest(imu: ImuSeries, quantum: float = 0.0) -> Rest:
    """Return the longest run of seconds of one mean; ``quantum`` [m/s2] is a count's worth of a second."""
    second = whole_seconds(imu.t)
    count = np.bincount(second)
    still = np.ones(len(count) - 1, dtype=bool)
    for values, allowed in ((imu.f_b, SAME_FORCE + 2 * quantum), (imu.omega_b, SAME_RATE)):
        steps = np.abs(np.diff(second_means(second, values), axis=0))
        still &= (steps.max(axis=1) < allowed) & (count[1:] > 0) & (count[:-1] > 0)
    edges = np.flatnonzero(np.diff(np.r_[False, still, False].astype(np.int8)))
    if not len(edges):
        return Rest(0, 0, 0.0)
    begins, ends = edges[::2], edges[1::2] + 1  # a run of n equal steps is n + 1 seconds
    longest = int(np.argmax(ends - begins))
    first, last = np.searchsorted(second, [begins[longest], ends[longest]]).tolist()
    return Rest(first, last, float(ends[longest] - begins[longest]))


def noise_densities(
    imu: ImuSeries, rest: Rest, period: float, calibration: Mapping[str, Any] | None,
    quantum: tuple[float, float] = (0.0, 0.0),
) -> ImuNoise:  # fmt: skip
    """Return the densities of a unit from its rest, where that is too short from its quietest seconds.

    ``quantum`` is a count's worth of angle [rad] and of velocity [m/s]. Without a ``calibration`` the biases are
    those of any IMU.
    """
    terms = _terms if rest.seconds >= MIN_REST_S else _quietest
    part = slice(rest.first, rest.last) if rest.seconds >= MIN_REST_S else slice(None)
    gyro, gyro_walk = terms(imu.omega_b[part], period, quantum[0])
    accel, accel_walk = terms(imu.f_b[part], period, quantum[1])
    biases: dict[str, float] = {}
    if calibration is not None:
        gyro_walk, accel_walk = min(gyro_walk, GYRO_BIAS_WALK), min(accel_walk, FORCE_WALK)
        biases = {"gyro_bias": gyro_bias_std(calibration), "accel_bias": force_bias_std(calibration)}
    return ImuNoise(
        max(gyro, MIN_GYRO_NOISE), max(gyro_walk, MIN_BIAS_WALK),
        max(accel, MIN_FORCE_NOISE), max(accel_walk, MIN_BIAS_WALK), **biases,
    )  # fmt: skip


def _terms(values: FloatArray, period: float, quantum: float) -> tuple[float, float]:
    """Return white noise and walk of the worst axis of samples (n, 3), of counting what it makes of a second."""
    white, walk = list[float](), list[float]()
    for axis in range(3):
        terms = fit_noise(overlapping_deviation(values[:, axis], period), quantum).terms
        white.append(terms["random_walk"].value or terms["random_walk"].high)
        walk.append(terms["rate_random_walk"].value or terms["rate_random_walk"].high)
    counting = quantum / np.sqrt(6 * COUNTED_S)  # of the difference of two counts, each off by less than one
    return float(np.hypot(max(white), counting)), max(walk)


def _quietest(values: FloatArray, period: float, quantum: float) -> tuple[float, float]:
    """Return white noise of the quietest seconds of a motion, and a walk as large in a minute."""
    white = white_noise(values, period)
    counting = quantum / np.sqrt(6 * COUNTED_S)
    return float(np.hypot(white, counting)), white / MINUTE_S
