"""The sample rate that a device declares against GNSS time: beyond 0.1 % a warning, beyond 1 % a refusal.

A device's own time follows its counter: where a sync line drives it, counter, time and every health bit look right
while all rates are wrong.
"""

import math
import time
from collections import deque
from collections.abc import Callable

import numpy as np

from procedures.diagnosis.clock import ClockRate, fit_clock
from station.campaign_folder.loaded import REFUSE_PERIOD, clock_sentence, off_period
from station.campaign_folder.series import WARN_PERIOD
from station.errors import DataRefused
from station.gnss.feed import GnssFeed
from station.live.live_feed import LiveFeed
from station.recorder.row_times import RowTimes, Utc

KEPT = 4000  # stamps, 200 s
LEAST = 100
EVERY_S = 2.0
SIGMAS = 4.0
LINE = 2.0  # scatters of a mark by which UTC at the two ends of the stamps may be off, each end as a whole


class SampleRate:
    """Watches one stream; call `look` often.

    ``scatter`` [s] is that of a mark about the line which ``utc`` reads. Stamps of many seconds share that line's
    error, which a fit through them does not see: above all at the beginning, when it goes through few marks.
    """

    def __init__(self, feed: LiveFeed, utc: Utc, scatter: Callable[[], float] = lambda: 0.0) -> None:
        self._feed, self._times, self._scatter = feed, RowTimes(utc), scatter
        self._stamps: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self._next = 0.0
        self.clock: Callable[[], float] = time.monotonic
        self.rate: ClockRate | None = None
        self.warning = ""

    def look(self) -> None:
        """Take the newest sample; say what is wrong in ``warning``.

        Raises
        ------
        DataRefused
            If the rate is surely more than 1 % off.
        """
        self._take()
        now = self.clock()
        if len(self._stamps) < LEAST or now < self._next:
            return
        self._next = now + EVERY_S
        self.rate = fit_clock(*np.array(self._stamps).T)
        if self.rate is None:
            return
        span = self._stamps[-1][0] - self._stamps[0][0]
        off, surely = (
            off_period(self.rate),
            SIGMAS * math.hypot(self.rate.std * 1e-6, LINE * self._scatter() / span),
        )
        period = self._feed.period
        self.warning = clock_sentence(period, off) if abs(off) - surely > WARN_PERIOD else ""
        if abs(off) - surely > REFUSE_PERIOD:
            raise DataRefused(
                self._feed.address.name, None, clock_sentence(period, off), "the declared rate within 1 %",
                "check the sync line and the rate that the device is set to",
            )  # fmt: skip

    def _take(self) -> None:
        if self._feed.stamp is None:
            return
        host_ns, device_s = self._feed.stamp
        if self._stamps and device_s <= self._stamps[-1][0]:
            if device_s < self._stamps[-1][0]:  # it began anew
                self._stamps.clear()
            return
        if (utc := self._times.of(host_ns)) is not None:
            self._stamps.append((device_s, utc))


class Timed:
    """A receiver beside a plain recording: UTC for its rows; what its rate's check says stands in ``said``."""

    def __init__(self, gnss: GnssFeed, feed: LiveFeed) -> None:
        self._gnss, self._rate = gnss, SampleRate(feed, gnss.utc, gnss.utc_scatter)
        self.said = ""

    def advance(self) -> None:
        """Take what has come; a rate that is off is evidence here, so that the recording goes on."""
        self._gnss.advance()
        try:
            self._rate.look()
            self.said = self._rate.warning
        except DataRefused as error:
            self.said = str(error)

    def utc(self, host_ns: int) -> float | None:
        """Return UTC [s] at a moment of the station's clock [ns]."""
        return self._gnss.utc(host_ns)
