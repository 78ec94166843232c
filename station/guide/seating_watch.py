"""Is the cube seated as the dwells before it say it should be? Judged while the hands are still near.

A crumb or a hair under the cube tilts it by tens of arcseconds: invisible, and far above what a calibration may
be off. What comes back the same after lifting, wiping and setting down is no crumb but the bench: it is taken.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.seating_check import (
    PLAUSIBLE_FACE_TILT_RAD,
    PositionRates,
    Seating,
    judge,
    seating,
)
from procedures.units import ARCSEC_PER_DEG
from station.guide.accepted_dwell import AcceptedDwell, rates_and_sigmas
from station.guide.dwell_attempt import DwellAttempt
from station.guide.setup_view import Choice
from station.guide.stage_context import BenchFacts, StageContext
from station.guide.view import OperatorQuestion
from station.stream.recorder.sample_buffer import SampleRun

LOOKS_S = (3.0, 6.0, 10.0, 20.0, 40.0, 70.0)  # of accepted seconds
ALIKE_RAD = 5e-5  # 10 arcsec, or three sigma
KEPT_SHARE = 0.2  # of a kept seat's tilt: by so much it may move as it is let go
FIRST_ON_FACE = "first placement on this face: nothing to compare with yet"
FIRST_SINCE_ON = "first placement on this face since power-on: not checked yet"
SHARP_RAD = 3e-4  # rad, 1 sigma: a crumb of 0.1 deg is told
CONTRADICTORY = "not checked: the earlier placements contradict each other"


class SeatCheck:
    """Judges the seat of one attempt at a dwell on ``face``; or, where it is none ``is_again``, of a turn."""

    def __init__(self, context: StageContext, face: str, *, is_again: bool = True) -> None:
        self._context, self.face, self._is_again = context, face, is_again
        self._looks = list(LOOKS_S)
        self.words, self.is_off = "", False
        self.is_to_lift = False  # off, and neither kept nor the bench's
        self.is_sharp = False  # well enough known to tell a crumb
        self.came_back: FloatArray | None = None  # (2,) [rad]: just so after lifting, by more than a face may be
        self._off: FloatArray | None = None  # as it was last found

    @property
    def kept(self) -> FloatArray | None:
        """How far off (2,) [rad] the cube sits that the operator takes so; None where it sits well."""
        return self._off if self.is_off else None

    def fault(self, dwelling: DwellAttempt, position: int) -> str:
        """Look when it is time to; return why the cube should be lifted, empty if it need not."""
        if not position or not self._looks or dwelling.accepted_s < self._looks[0]:
            return ""
        while self._looks and dwelling.accepted_s >= self._looks[0]:
            self._looks.pop(0)
        return self.last_fault(dwelling, position)

    def last_fault(self, dwelling: DwellAttempt, position: int) -> str:
        """Look now."""
        return self.judged(dwelling.runs(), position)

    def judged(self, runs: Sequence[SampleRun], position: int) -> str:
        """Look at what ``runs`` hold; return why the cube should be lifted, empty if it need not."""
        context, self.came_back = self._context, None
        now = [each for each in context.well_seated if each.position != position or not self._is_again]
        if not any(each.face == self.face for each in (*now, *(each for each, _ in context.earlier_dwells))):
            return self._not_judged(FIRST_ON_FACE)
        accel, std = rates_and_sigmas(context.accel_rates(runs))
        found = compared(context.bench, context.judges, (position, accel, std), is_again=self._is_again)
        if found is None:
            return self._not_judged(CONTRADICTORY)
        why = judge(found)
        self.is_sharp = bool(found.std.max() < SHARP_RAD)
        if not why and not self.is_sharp and not any(each.face == self.face for each in now):
            return self._not_judged(FIRST_SINCE_ON)
        self.is_off, self._off = bool(why), found.off
        arcsec = np.degrees(np.abs(found.off).max()) * ARCSEC_PER_DEG
        self.words = why or f"seating error within {arcsec:.0f} arcsec"
        self.is_to_lift = False
        if why and self._is_kept(position, found):
            self.words = f"kept: {why}"
            return ""
        if not why or self._is_known(position, found):
            return ""
        self.is_to_lift = True
        context.seats[position], context.off_seat = found.off, position
        return f"not seated: {why}; lift, wipe, set down"

    def _not_judged(self, why: str) -> str:
        self.is_to_lift = False
        self.words, self.is_off, self._off = why, False, None
        return ""

    def _is_kept(self, position: int, found: Seating) -> bool:
        """Say whether this is the seat that the operator keeps, and not another one."""
        if (kept := self._context.kept_seats.get(position)) is None:
            return False
        near = max(ALIKE_RAD, 3 * float(found.measured_std.max()), KEPT_SHARE * float(np.linalg.norm(kept)))
        return bool(np.linalg.norm(found.off - kept) < near)

    def _is_known(self, position: int, found: Seating) -> bool:
        """Say whether the cube sat just so before it was lifted: then it is the bench."""
        if (before := self._context.seats.get(position)) is None:
            return False
        near = np.maximum(ALIKE_RAD, 3 * found.measured_std)
        if alike := bool(np.all(np.abs(found.off - before) < near)):
            # no cube's own face is tilted by more: this seat or one before it is wrong, and the verdict says so
            self.is_off = bool(np.linalg.norm(found.off) > PLAUSIBLE_FACE_TILT_RAD)
            self.came_back = found.off if self.is_off else None
            self.words = "the same after lifting: accepted"
        return alike


def compared(
    bench: BenchFacts, known: Sequence[tuple[AcceptedDwell, int]], now: PositionRates, *, is_again: bool
) -> Seating | None:
    """Compare how the cube sits with dwells that are ``known``, each with its turn-on, 0 being the present one."""
    before, turn_ons = [(each.position, each.accel, each.accel_std) for each, _ in known], [on for _, on in known]
    return seating(before, now, bench.fixture, bench.heading_std, turn_ons=turn_ons, is_again=is_again)


def keep_question(context: StageContext) -> OperatorQuestion | None:
    """Return what is to be asked before the cube is kept as it sits; None where that is plausible."""
    off = float(np.linalg.norm(context.seats[context.off_seat]))
    if off <= PLAUSIBLE_FACE_TILT_RAD:
        return None
    text = (
        f"The cube is tilted by {np.degrees(off):.2f} deg. A clean seating is not tilted so much. If you keep it, "
        f"it is recorded as tilted and the calibration will be wrong. Keep it?"
    )
    choices = (
        Choice(key="n", title="no: lift, wipe, place again"),
        Choice(key="y", title="yes, keep this seating"),
    )
    return OperatorQuestion(text=text, choices=choices)
