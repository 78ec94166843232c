"""Start of IMU and GNSS: an alignment at rest or in motion, attempted until one succeeds.

At rest specific force gives the level and the Earth's rate the heading (gyrocompassing): ``yaw_std = bias_std /
(Omega cos lat)``, ``tilt_std = accel_bias / g``. In motion the attempts wait for displacement and observability;
the last one reports what is missing.
"""

from collections.abc import Iterator

import numpy as np

from procedures.arrays import FloatArray
from procedures.free_positions.rest_detection import second_means, whole_seconds
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import (
    MAX_TILT_STD,
    MAX_YAW_STD,
    AlignmentState,
    GnssFixes,
    ImuNoise,
    ImuSeries,
    Waiting,
    in_degrees,
)
from procedures.fusion.preintegration import imu_gaps
from procedures.gyrocompass import attitude_at_rest

MAX_FORCE_CHANGE = 5e-3  # m/s2 of a second's mean specific force, in addition to its noise, that a bench may have
MAX_RATE_CHANGE = 1e-4  # rad/s of a second's mean rate
STILLNESS_SIGMAS = 5.0
MIN_REST_S = 5.0  # s


def is_still(imu: ImuSeries, noise: ImuNoise) -> bool:
    """Say whether second by second specific force and rate stay what they were, but for their noise."""
    second = whole_seconds(imu.t)
    count = np.bincount(second)
    full = count >= 0.5 * np.median(count)
    triads = ((imu.f_b, noise.accel, MAX_FORCE_CHANGE), (imu.omega_b, noise.gyro, MAX_RATE_CHANGE))
    for values, density, allowed in triads:
        means = second_means(second, values)[full]
        if np.abs(means - np.median(means, axis=0)).max() > STILLNESS_SIGMAS * np.hypot(density, allowed):
            return False
    return True


def align_at_rest(
    imu: ImuSeries, noise: ImuNoise, gravity: float, earth_n: FloatArray
) -> AlignmentState | Waiting:
    """Align by the means over all samples and Earth's rate ``earth_n`` (3,) [rad/s], or say what is missing."""
    elapsed = float(imu.t[-1] - imu.t[0])
    if elapsed < MIN_REST_S or not is_still(imu, noise):
        return Waiting(f"it does not stand still for {MIN_REST_S:g} s")
    f, omega = imu.f_b.mean(axis=0), imu.omega_b.mean(axis=0)
    C_nb, horizontal = attitude_at_rest(f, omega), float(earth_n[1])
    rate_std = np.hypot(noise.gyro_bias, noise.gyro / np.sqrt(elapsed))
    yaw_std = float(rate_std / max(horizontal, 1e-12))
    tilt_std = float(np.hypot(noise.accel_bias, noise.accel / np.sqrt(elapsed)) / gravity)
    if yaw_std > MAX_YAW_STD or tilt_std > MAX_TILT_STD or C_nb is None:
        tilt, yaw, tilt_asked, yaw_asked = in_degrees(tilt_std, yaw_std, MAX_TILT_STD, MAX_YAW_STD)
        return Waiting(
            f"at rest the Earth's rate gives yaw to {yaw:.1f} deg and gravity tilt to {tilt:.1f} deg (u), "
            f"{yaw_asked:.0f} and {tilt_asked:.0f} are needed: move it, or use better gyros"
        )
    std = np.r_[tilt_std, tilt_std, yaw_std, [1e-3] * 3, [rate_std] * 3, [noise.accel_bias] * 3]
    zero = np.zeros(3)
    return AlignmentState(
        float(imu.t[0]), C_nb, zero, zero, zero, np.diag(std**2), float(imu.t[-1]), C_nb, tilt_std, yaw_std, 1.0
    )


FIRST_ATTEMPT_S = 3.0  # s after which it is worth a try
ATTEMPT_SPACING_RATIO = 1.1  # later attempts are as much farther apart, and at least `MIN_ATTEMPT_SPACING_S`
MIN_ATTEMPT_SPACING_S = 1.0  # s
MAX_GAP_ATTITUDE_STD = np.radians(0.5)  # over a gap of the IMU, beyond which only what follows it is looked at
MOTION_WINDOW_S = 30.0  # s of motion that are looked at: biases move
MIN_FIXES = 12  # at least, however far apart they are


def align_when_possible(aligner: MovingAligner, imu: ImuSeries, fixes: GnssFixes) -> AlignmentState | Waiting:
    """Return the first alignment that the data allow, none of which uses anything later than its ``t``."""
    start = max(float(imu.t[0]), float(fixes.t[0]))
    end = min(float(imu.t[-1]), float(fixes.t[-1]))
    found: AlignmentState | Waiting = Waiting("IMU and GNSS overlap for less than three seconds")
    torn = [gap.last for gap in imu_gaps(imu) if gap.rate_std * gap.length > MAX_GAP_ATTITUDE_STD]
    for now in attempt_times(start, end, FIRST_ATTEMPT_S, MIN_ATTEMPT_SPACING_S):
        found = attempt(aligner, imu, fixes, max([start, *(last for last in torn if last <= now)]), now)
        if isinstance(found, AlignmentState):
            break
    return found


def attempt_times(start: float, end: float, first: float, spacing: float) -> Iterator[float]:
    """Yield the times [s] of attempts, ``first`` [s] after the start and at least ``spacing`` [s] apart."""
    now = start + first
    while now <= end:
        yield now
        now += max(spacing, (ATTEMPT_SPACING_RATIO - 1) * (now - start))


def attempt(
    aligner: MovingAligner, imu: ImuSeries, fixes: GnssFixes, start: float, now: float
) -> AlignmentState | Waiting:
    """Try once, by the data from ``start`` to ``now`` [s], at rest and in motion."""
    resting = align_at_rest(between(imu, start, now), aligner.noise, aligner.gravity, aligner.earth_n)
    if isinstance(resting, AlignmentState):
        return resting
    earliest = max(int(np.searchsorted(fixes.t, now, "right")) - MIN_FIXES, 0)
    since = max(min(now - MOTION_WINDOW_S, float(fixes.t[earliest])), start)
    moving = aligner.align(between(imu, since - 1, now), fixes_between(fixes, since, now))
    if isinstance(moving, Waiting) and "is not at rest" not in resting.why:
        return resting
    return moving


def between(imu: ImuSeries, first: float, last: float) -> ImuSeries:
    """Return the samples of a span of time [s]."""
    part = _span(imu.t, first, last)
    return ImuSeries(imu.t[part], imu.omega_b[part], imu.f_b[part])


def fixes_between(fixes: GnssFixes, first: float, last: float) -> GnssFixes:
    """Return the fixes of a span of time [s]."""
    return fixes.part(_span(fixes.t, first, last))


def _span(t: FloatArray, first: float, last: float) -> slice:
    return slice(int(np.searchsorted(t, first)), int(np.searchsorted(t, last, "right")))
