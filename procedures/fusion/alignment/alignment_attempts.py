"""When an IMU and GNSS know which way they stand: tried again and again until they do, at rest or in motion.

It waits for displacement and observability, not for a time; what is missing is said by the last attempt.
"""

from collections.abc import Iterator

import numpy as np

from procedures.fusion.alignment.alignment_at_rest import align_at_rest
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState, Waiting
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.imu_gaps import imu_gaps

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
    part = slice(int(np.searchsorted(imu.t, first)), int(np.searchsorted(imu.t, last, "right")))
    return ImuSeries(imu.t[part], imu.omega_b[part], imu.f_b[part])


def fixes_between(fixes: GnssFixes, first: float, last: float) -> GnssFixes:
    """Return the fixes of a span of time [s]."""
    part = slice(int(np.searchsorted(fixes.t, first)), int(np.searchsorted(fixes.t, last, "right")))
    return fixes.part(part)
