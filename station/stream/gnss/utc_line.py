"""UTC at moments of the station's clock, from marks at which a receiver's UTC was read."""

from bisect import bisect_left

import numpy as np

from procedures.statistics.line_fits import TimeLine, fit_earliest_line

AROUND_NS = 30 * 10**9  # of a moment: the marks its time is taken from
REFIT_NS = 10**9  # how old the newest line may be


class UtcLine:
    """Marks in order, and the line along those around a moment that came least late."""

    def __init__(self) -> None:
        self._marks: tuple[list[int], list[int]] = [], []  # host, UTC [ns]
        self._line: tuple[tuple[int, int], TimeLine | None] = (0, 0), None

    def mark(self, host_ns: int, utc_ns: int) -> None:
        """Take a mark: UTC [ns] that was read at a moment of the station's clock [ns]."""
        self._marks[0].append(host_ns)
        self._marks[1].append(utc_ns)

    def begin_anew(self) -> None:
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
        """Return UTC [s since 1970] at a moment of the station's clock [ns]; None where the marks do not tell."""
        line = self.around(host_ns)
        return None if line is None else line.at(host_ns)

    @property
    def scatter(self) -> float:
        """The 1 sigma [s, UTC] of one mark about the line that was read last; 0 before there is one."""
        return self._line[1].scatter if self._line[1] else 0.0
