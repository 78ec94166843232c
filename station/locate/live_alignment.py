"""What comes before a live location: the unit's noise from its rest, then an alignment, tried again and again."""

from dataclasses import dataclass, replace

import numpy as np

from procedures.fusion.alignment.alignment_attempts import (
    FIRST_ATTEMPT_S,
    MIN_ATTEMPT_SPACING_S,
    MOTION_WINDOW_S,
    attempt,
    between,
)
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState, Waiting
from procedures.fusion.fusion_records import GnssFixes, ImuSeries

LONGEST_REST = 60.0  # s of a rest that the window goes through again: its data are what the heading is known by
MAX_BUFFER_S = 300.0  # s of samples
ATTEMPT_SPACING = 0.05  # of the time so far, between two attempts


@dataclass(frozen=True, slots=True, eq=False)
class LiveStart:
    """An alignment, and the samples and fixes from which the window begins."""

    aligned: AlignmentState
    imu: ImuSeries
    fixes: GnssFixes


class LiveAlignment:
    """Tries at growing intervals; ``why`` says what is missing."""

    def __init__(self, aligner: MovingAligner) -> None:
        self._aligner, self.noise = aligner, aligner.noise
        self._start: float | None = None
        self._next = 0.0
        self.why = "waiting for fixes"

    def attempt(self, imu: ImuSeries, fixes: GnssFixes) -> LiveStart | None:
        """Return a beginning if it is time for an attempt and that succeeds."""
        now = min(float(imu.t[-1]), float(fixes.t[-1]))
        if self._start is None:
            self._start = max(float(imu.t[0]), float(fixes.t[0]))
            self._next = self._start + FIRST_ATTEMPT_S
        if now < self._next:
            return None
        self._next = now + max(MIN_ATTEMPT_SPACING_S, ATTEMPT_SPACING * (now - self._start))
        found = attempt(self._aligner, imu, fixes, self._start, now)
        if isinstance(found, Waiting):
            self.why = found.why
            return None
        first = max(found.t0, now - max(LONGEST_REST, MOTION_WINDOW_S))
        return LiveStart(replace(found, t0=first), between(imu, first - 1.0, now), fixes)


def joined_series(parts: list[ImuSeries]) -> ImuSeries:
    """Return consecutive samples as one series."""
    return ImuSeries(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "omega_b", "f_b"))
    )
