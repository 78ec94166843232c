"""The fixes of a live run: on the IMU's clock, level about the first, and which keyframe each one asks for."""

from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np

from procedures.earth.geodesy import LocalLevel
from procedures.earth.gnss_records import GnssFix, TimeMark
from procedures.fusion.fixes_east_north_up import antenna, is_usable, level_fixes, origin_at
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.inner.keyframes import CLOSEST, SPACING
from station.files.mcap_files.fix_reader import Record
from station.stream.gnss.fix_times import FixTimes

MARKS_NS = 60 * 10**9  # of the lines between the clocks
KEYFRAME_DELAY_S = (0.1, 1.0)  # s: how far behind the newest sample keyframes may stand
EARLY_S = 0.06  # by which a fix is to be known before a keyframe comes near it
AGE_FIXES = 20  # fixes, whose lateness is looked at
STRANGE_S = 5.0  # from the newest sample, beyond which a fix's time is none
MAX_TAKEN_FIXES, KEPT_TAKEN_FIXES = 2000, 1000  # fixes that are kept once they are taken


class LiveFixes:
    """``origin``: where the first fix stood; ``fixes``: those kept of ``count``; ``taken`` lie behind."""

    def __init__(self, origin: LocalLevel | None = None) -> None:
        self.origin = origin
        self.fixes: GnssFixes | None = None
        self.taken = self.count = 0
        self._times = FixTimes(MARKS_NS)
        self._source = ""
        self._ages: deque[float] = deque(maxlen=AGE_FIXES)

    def mark(self, marks: Iterable[tuple[int, float]], pulses: Iterable[float] = ()) -> None:
        """Take moments of reading [ns] with the device times [s] of the samples that came then, and of pulses."""
        for host_ns, device_s in marks:
            self._times.mark_imu(host_ns, device_s)
        for device_s in pulses:
            self._times.mark_pulse(device_s)

    def take(self, records: Sequence[Record], now: float) -> GnssFixes | None:
        """Return what is new among records, None where nothing is; ``now`` [s] is the newest sample's time."""
        before = 0 if self.fixes is None else len(self.fixes.t)
        for record in records:
            if isinstance(record, TimeMark):
                self._times.mark_sender(record)
            elif isinstance(record, GnssFix) and is_usable(record):
                self._source = self._source or antenna([record])
                t = self._times.of(record) if record.source == self._source else None
                if t is not None and abs(now - t) < STRANGE_S and (self.fixes is None or t > self.fixes.t[-1]):
                    self._place(record, t, now)
        return None if self.fixes is None or len(self.fixes.t) == before else self.fixes.part(slice(before, None))

    def _place(self, fix: GnssFix, t: float, now: float) -> None:
        self.origin = self.origin or origin_at(fix)
        self._ages.append(now - t)
        new = level_fixes(self.origin, np.array([t]), [fix])
        self.fixes = new if self.fixes is None else self.fixes.followed_by(new)
        self.count += 1

    @property
    def lateness(self) -> float:
        """How far behind the newest sample [s] keyframes are to stand."""
        return float(np.clip(max(self._ages, default=0.0) + EARLY_S, *KEYFRAME_DELAY_S))

    @property
    def newest_taken(self) -> float:
        """The time [s] of the newest fix that has its keyframe."""
        assert self.fixes is not None
        return float(self.fixes.t[max(self.taken - 1, 0)])

    @property
    def std(self) -> float:
        """1 sigma [m] of each axis of that fix, as the receiver says."""
        assert self.fixes is not None
        return float(self.fixes.position_std[max(self.taken - 1, 0)])

    def forget(self) -> None:
        """Let old fixes go that have their keyframes."""
        if self.fixes is not None and self.taken > MAX_TAKEN_FIXES:
            self.fixes, self.taken = self.fixes.part(slice(KEPT_TAKEN_FIXES, None)), self.taken - KEPT_TAKEN_FIXES

    def next_keyframe(self, last: float, until: float) -> float | None:
        """Return the time of the keyframe after ``last`` [s]; None if it is after ``until``.

        Keyframes stand at fixes, and between them evenly, at most `SPACING` apart.
        """
        assert self.fixes is not None
        t, k = self.fixes.t, self.taken
        while k < len(t) and t[k] < last + CLOSEST:
            k += 1  # on the heels of a keyframe, or too late
        if k < len(t) and (gap := float(t[k]) - last) < 2 * SPACING + CLOSEST:
            parts = max(1, int(np.ceil(gap / SPACING - 0.5)))
            at = float(t[k]) if parts == 1 else last + gap / parts
        else:
            at = last + SPACING
        return None if at > until else at

    def passed(self, t: float) -> range:
        """Return which fixes a keyframe at ``t`` [s] leaves behind that none has before."""
        assert self.fixes is not None
        first, self.taken = self.taken, max(self.taken, int(np.searchsorted(self.fixes.t, t, "right")))
        return range(first, self.taken)
