"""When samples were taken: by this machine's clock, and in UTC where a receiver or its pulse tells."""

import numpy as np

from procedures.arrays import FloatArray, IntArray
from station.stream.live.sample_moments import SampleMoments
from station.stream.recorder.row_times import RowTimes, Utc

LOOK_NS = 10**8  # how often the link's delay is looked at


class SampleTimes:
    """Times of one stream's samples; ``utc`` gives UTC [s] of a moment of this machine's clock [ns], or None.

    ``is_by_messages`` says whether the UTC last given is by when messages came, not by a pulse.
    """

    def __init__(self, utc: Utc | None) -> None:
        self._utc, self._rows = utc, RowTimes(utc)
        self._moments = SampleMoments()
        self._next_ns, self._lag_ns = 0, 0
        self._pulsed: float | None = None  # UTC less device time [s], by the last pulse
        self.is_by_messages = False

    def begin_anew(self) -> None:
        """Forget what the device's clock was held to: it may have begun anew."""
        self._moments.begin_anew()
        self._rows.begin_anew()
        self._next_ns, self._pulsed = 0, None

    def of(self, t: FloatArray, read_ns: int, pulse_age: float | None) -> tuple[IntArray, FloatArray]:
        """Return moments (n,) [ns] and UTC (n,) [s] of samples at device times ``t`` (n,) [s] of one read.

        ``pulse_age`` is how long before the last of them a pulse came [s], None: not told.
        """
        last = float(t[-1])
        if read_ns >= self._next_ns:
            self._next_ns = read_ns + LOOK_NS
            self._lag_ns = self._moments.of(last, read_ns) - round(last * 1e9)
        lag = min(self._lag_ns, read_ns - round(last * 1e9))
        taken = np.round(t * 1e9).astype(np.int64) + lag
        told = self._rows.of(read_ns, last, pulse_age)
        if told is not None and self._rows.is_pulsed:
            self._pulsed = told - last
        elif not self._rows.is_pulsed:
            self._pulsed = None
        if self._pulsed is not None:
            self.is_by_messages = False
            return taken, t + self._pulsed
        by_messages = None if self._utc is None else self._utc(int(taken[-1]))
        self.is_by_messages = by_messages is not None
        return taken, t + (np.nan if by_messages is None else by_messages - last)
