"""Is the cube seated as the dwells before it say it should be? Judged while the hands are still near.

A crumb or a hair under the cube tilts it by tens of arcseconds: invisible, and far above what a calibration may
be off. What comes back the same after lifting, wiping and setting down is no crumb but the bench: it is taken.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.seating import Seating, judge, seating
from station.guide.desk import Desk
from station.guide.dwelling import Dwelling
from station.guide.rested import estimates, rates
from station.live.spans import series

LOOKS_S = (3.0, 6.0, 10.0, 20.0, 40.0, 70.0)  # of accepted seconds
ALIKE_RAD = 5e-5  # 10 arcsec, or three sigma


class Seat:
    """Judges the seat of one attempt at a dwell on ``face``."""

    def __init__(self, desk: Desk, face: str) -> None:
        self._desk, self._face = desk, face
        self._looks = list(LOOKS_S)
        self.words, self.is_off = "", False

    def fault(self, dwelling: Dwelling, position: int) -> str:
        """Look when it is time to; return why the cube should be lifted, empty if it need not."""
        if not position or not self._looks or dwelling.accepted_s < self._looks[0]:
            return ""
        while self._looks and dwelling.accepted_s >= self._looks[0]:
            self._looks.pop(0)
        return self.last_fault(dwelling, position)

    def last_fault(self, dwelling: Dwelling, position: int) -> str:
        """Look now."""
        desk = self._desk
        recorded = series(desk.feed.tape, dwelling.runs(), desk.feed.period)
        accel, std = rates(estimates(recorded.accel, recorded))
        before = [(each.position, each.accel, each.accel_std) for each in desk.rested.values()]
        facts = desk.facts
        found = seating(before, (position, accel, std), facts.fixture, facts.heading_std)
        if found is None:
            self.words = "the first on this face: nothing to compare it with yet"
            return ""
        why = judge(found)
        self.is_off, self.words = bool(why), why or _words(found)
        if not why or position in desk.kept_seats or self._is_known(position, found):
            return ""
        desk.seats[position], desk.off_seat = found.off, position
        return f"not seated: {why}; lift, wipe, set down"

    def _is_known(self, position: int, found: Seating) -> bool:
        """Say whether the cube sat just so before it was lifted: then it is the bench."""
        if (before := self._desk.seats.get(position)) is None:
            return False
        near = np.maximum(ALIKE_RAD, 3 * found.measured_std)
        if alike := bool(np.all(np.abs(found.off - before) < near)):
            self.words, self.is_off = "the same again after lifting: taken as it is", False
        return alike


def _words(found: Seating) -> str:
    return f"seated within {_arcsec(np.abs(found.off).max()):.0f} arcsec"


def _arcsec(angle: float | FloatArray) -> float:
    return float(np.degrees(angle) * 3600)
