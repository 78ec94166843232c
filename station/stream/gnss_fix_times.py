"""Time stamps of a GNSS receiver: when a fix was valid by the IMU's clock, and UTC by the station's clock.

A receiver reports late, by a delay that its own stamps show. Where the IMU is given a pulse at each whole second
(PPS) and reports when it came, a fix that has UTC is placed by the pulses.
"""

from bisect import bisect_left
from collections import deque
from itertools import islice

import numpy as np

from drivers.camera import CameraImage
from drivers.can.frame_record import WheelReading
from procedures.gnss_records import GnssFix, TimeMark
from procedures.statistics.line_fits import TimeLine, fit_earliest_line, fit_time_line

REFIT_NS = 10**9
REBOOT_NS = 10**9
MAX_AHEAD_NS = 10**8  # nothing is read before it was sent: a sender's clock that is ahead by more was set
MIN_PULSE_SPACING_S = 0.5
MAX_PULSE_AGE_S = 30.0  # s from a pulse, within which the IMU's clock carries it on to a millisecond
MAX_PULSE_OFF_S = (
    0.3  # s that the lines may be off: of a fix midway between two seconds nobody could say which it is
)
LATE_NS = 250_000_000  # later than the soonest so far: such a stamp shows the delay on the way, not the clock
DRIFT = 2e-4  # by which a sender's clock may be slow
RECENT_MARKS = 20  # marks of a sender with which a new one is compared
Marks = deque[tuple[int, int]]


class FixTimes:
    """Marks of the last ``span_ns`` [ns] of the station's clock; of all where it is None.

    ``in_order``: a sender's marks never overtake each other, so that any time that goes back is a new clock's;
    those that lag far behind the soonest are omitted, or the line would go through the lag.
    """

    def __init__(self, span_ns: int | None = None, *, in_order: bool = False) -> None:
        self._span_ns, self._in_order, self._back_ns = span_ns, in_order, 0 if in_order else REBOOT_NS
        self._soonest: TimeMark | None = None
        self._newest_ns = 0  # the sender's newest time
        self._imu, self._sender = Marks(), Marks()
        self._pulses = list[float]()
        self._asked = self._by_pulses = 0  # fixes, and those of them that a pulse placed
        self._past = list[tuple[int, TimeLine | None]]()  # until when [ns] a clock of the sender's held
        self._lines: dict[str, tuple[tuple[int, int], TimeLine | None]] = {}

    def reset(self) -> None:
        """Discard the IMU's time stamps: its time has restarted."""
        self._imu.clear()
        self._pulses.clear()
        self._lines.pop("imu", None)

    def stamp_imu(self, host_ns: int, device_s: float) -> None:
        """Take the moment at which a sample of the IMU was read [ns], and the sample's own time [s]."""
        self._imu.append((host_ns, round(device_s * 1e9)))

    def stamp_sender(self, mark: TimeMark) -> None:
        """Take the moment at which the sender's time was read; one that goes back, or leaps, is a new clock's."""
        if self._sender and self._is_new(mark):
            self._past.append((self._sender[-1][0], fit_time_line(*np.array(self._sender, dtype=np.int64).T)))
            self._sender.clear()
            self._lines.pop("sender", None)
            self._soonest = None
        self._newest_ns = mark.device_ns
        if not self._lags(mark):
            self._sender.append((mark.host_ns, mark.device_ns))

    def _lags(self, mark: TimeMark) -> bool:
        """Return whether a mark in order came far later than the soonest, for which a slow clock may stand in."""
        if not self._in_order:
            return False
        if self._soonest is None:
            self._soonest = mark
        passed = mark.host_ns - self._soonest.host_ns
        later = passed * (1 - DRIFT) - (mark.device_ns - self._soonest.device_ns)
        if later <= 0:
            self._soonest = mark
        return later > LATE_NS

    def _is_new(self, mark: TimeMark) -> bool:
        soonest = max(device_ns - host_ns for host_ns, device_ns in islice(reversed(self._sender), RECENT_MARKS))
        leaps = mark.device_ns - mark.host_ns > soonest + MAX_AHEAD_NS
        return leaps or mark.device_ns < self._newest_ns - self._back_ns

    def of(self, fix: GnssFix | CameraImage | WheelReading) -> float | None:
        """Return when what came was valid [s of the IMU's clock]; None where it is not known yet."""
        imu = self._line("imu", self._imu)
        if imu is None:
            return None
        sender = None if fix.device_ns is None else self._sender_line(fix.host_ns)
        if sender is None or fix.device_ns is None:
            return self._by_pulse(fix, imu.at(fix.host_ns))
        return self._by_pulse(fix, imu.at(sender.when(fix.device_ns)))

    def stamp_pulse(self, device_s: float) -> None:
        """Take the IMU's time [s] of a pulse at a whole second; in order."""
        if not self._pulses or device_s > self._pulses[-1] + MIN_PULSE_SPACING_S:
            self._pulses.append(device_s)
        if self._span_ns is not None and self._pulses[0] < device_s - 2e-9 * self._span_ns:
            del self._pulses[: len(self._pulses) // 2]

    @property
    def all_by_pulse(self) -> bool:
        """Whether there were fixes, and a pulse placed each of them."""
        return 0 < self._asked == self._by_pulses

    def _by_pulse(self, fix: GnssFix | CameraImage | WheelReading, t: float) -> float:
        """Return a time ``t`` [s] of the IMU's clock as the pulse next to it has it, where it is near enough."""
        utc_ns = fix.utc_ns if isinstance(fix, GnssFix) else None
        self._asked += isinstance(fix, GnssFix)
        if utc_ns is None or not self._pulses:
            return t
        at = min(max(bisect_left(self._pulses, t), 1), len(self._pulses))
        pulse = min(self._pulses[at - 1 : at + 1], key=lambda each: abs(each - t))
        off = (pulse + utc_ns % 10**9 / 1e9 - t + 0.5) % 1.0 - 0.5
        is_near = abs(pulse - t) < MAX_PULSE_AGE_S and abs(off) < MAX_PULSE_OFF_S
        self._by_pulses += is_near
        return t + off if is_near else t

    @property
    def knows_sender(self) -> bool:
        """Whether fixes are placed by their sender's clock."""
        return self._line("sender", self._sender) is not None

    def _sender_line(self, host_ns: int) -> TimeLine | None:
        """Return the line of the clock that the sender had at a moment [ns]."""
        for until, line in self._past:
            if host_ns <= until:
                return line
        return self._line("sender", self._sender)

    def _line(self, name: str, marks: Marks) -> TimeLine | None:
        if not marks:
            return None
        key = marks[-1][0] // REFIT_NS, marks[0][0] // REFIT_NS if self._span_ns is None else 0
        held = self._lines.get(name)
        if held is None or held[0] != key or held[1] is None:
            while self._span_ns is not None and marks[0][0] < marks[-1][0] - self._span_ns:
                marks.popleft()
            self._lines[name] = key, fit_time_line(*np.array(marks, dtype=np.int64).T)
        return self._lines[name][1]


AROUND_NS = 30 * 10**9  # of a moment: the marks its time is taken from


class UtcLine:
    """Marks in order, and the line along those around a moment that came least late."""

    def __init__(self) -> None:
        self._marks: tuple[list[int], list[int]] = [], []  # host, UTC [ns]
        self._line: tuple[tuple[int, int], TimeLine | None] = (0, 0), None

    def mark(self, host_ns: int, utc_ns: int) -> None:
        """Take a mark: UTC [ns] that was read at a moment of the station's clock [ns]."""
        self._marks[0].append(host_ns)
        self._marks[1].append(utc_ns)

    def reset(self) -> None:
        """Let the marks go."""
        self._marks[0].clear()
        self._marks[1].clear()

    def around(self, host_ns: int) -> TimeLine | None:
        """Return the line between the station's clock and UTC around a moment [ns]; None for too few marks."""
        host, utc = self._marks
        key = host_ns // (AROUND_NS // 3), host[-1] // REFIT_NS if host else 0
        if self._line[0] != key:
            middle = key[0] * (AROUND_NS // 3)
            begin, end = bisect_left(host, middle - AROUND_NS), bisect_left(host, middle + 2 * AROUND_NS)
            window = (np.array(each[begin:end], dtype=np.int64) for each in (host, utc))
            self._line = key, fit_earliest_line(*window)
        return self._line[1]

    def utc(self, host_ns: int) -> float | None:
        """Return UTC [s since 1970] at a moment of the station's clock [ns]; None where it is not known."""
        line = self.around(host_ns)
        return None if line is None else line.at(host_ns)

    @property
    def scatter(self) -> float:
        """The 1 sigma [s, UTC] of one mark about the line that was read last; 0 before there is one."""
        return self._line[1].scatter if self._line[1] else 0.0
