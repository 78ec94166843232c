"""The sample rate that a device declares against another clock: beyond 0.1 % a warning, beyond 1 % a refusal.

A device's own time follows its counter: where a sync line drives it, counter, time and every health bit look right
while all rates are wrong.
"""

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable

import numpy as np

from procedures.campaign.campaign import MAX_CLOCK_PPM
from procedures.counts.reference_time import ClockRate, fit_clock
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.campaign_folder.loaded_campaign import MAX_PERIOD_DEVIATION, clock_sentence, off_period
from station.files.campaign_folder.sample_series import WARN_PERIOD_DEVIATION
from station.stream.live.live_feed import LiveFeed
from station.stream.recorder.sample_times import RowTimes, Utc

MAX_STAMPS = 4000  # stamps, 200 s
MIN_STAMPS = 100
EVERY_S = 2.0
SIGNIFICANT_SIGMAS = 4.0
SPAN_S = 30.0  # of this machine's clock: one that is held up for a moment is no wrong rate
MEASURED_S = 5.0  # the same for quite another rate
Reference = tuple[str, float, Callable[[], float]]  # as text, span [s] and scatter [s], as of `SampleRate`
PULSED: Reference = ("its reference pulses (PPS)", 0.0, lambda: 0.0)
END_SCATTERS = 2.0  # scatters of a mark by which UTC at the two ends of the stamps may be off, each end as a whole


class SampleRate:
    """Watches one stream; call `look` often.

    ``scatter`` [s] is that of a mark about the line which ``utc`` reads. Stamps of many seconds share that line's
    error, which a fit through them does not see: above all at the beginning, when it goes through few marks.
    ``by`` names the clock as text; with ``span_s`` [s] it is one of this machine's: no rate is judged before. A
    device that goes at quite another rate is simulated, or its sample period is wrong: ``pace`` says so, and it is
    no fault. Every ``every_s`` [s] it is fitted, which takes some milliseconds.
    """

    def __init__(
        self,
        feed: LiveFeed,
        utc: Utc,
        scatter: Callable[[], float] = lambda: 0.0,
        by: str = "reference time",
        span_s: float = 0.0,
        every_s: float = EVERY_S,
    ) -> None:
        self._feed, self._times = feed, RowTimes(utc)
        self._read_by: Reference = by, span_s, scatter
        self._by, self._span_s, self._scatter = self._read_by
        self._restarts = 0
        self._stamps: deque[tuple[float, float]] = deque(maxlen=MAX_STAMPS)
        self._next, self._every_s = 0.0, every_s
        self.clock: Callable[[], float] = time.monotonic
        self.rate: ClockRate | None = None
        self.warning = self.pace = ""
        self.is_pulsed = False  # that the reference is a pulse at the device's own input
        self._refused: DataRefused | None = None

    def look(self) -> None:
        """Take the newest sample; say what is wrong in ``warning``.

        Raise `DataRefused` if the rate is surely more than 1 % off.
        """
        self._take()
        now = self.clock()
        if len(self._stamps) >= MIN_STAMPS and now >= self._next:
            self._next = now + self._every_s
            self._fit()
        if self._refused is not None:
            raise self._refused

    @property
    def text(self) -> str:
        """What is wrong as text, where a rate that is off is evidence and ends nothing."""
        return str(self._refused) if self._refused is not None else self.warning or self.pace

    def warned(self) -> str:
        """Look, and return what then is `text`."""
        with contextlib.suppress(DataRefused):
            self.look()
        return self.text

    def _fit(self) -> None:
        span, by_clock = (self._stamps[-1][i] - self._stamps[0][i] for i in (0, 1))
        self.pace = self._rate_text(span / by_clock) if by_clock >= MEASURED_S else ""
        t, utc = np.array(self._stamps).T
        self.rate = fit_clock([(t, utc)]) if span >= self._span_s else None
        if self.rate is not None and not (self._span_s and abs(self.rate.ppm) > MAX_CLOCK_PPM):
            self._judge(self.rate, END_SCATTERS * self._scatter() / span)

    def _rate_text(self, ratio: float) -> str:
        if not self._span_s or abs(ratio - 1.0) * 1e6 <= MAX_CLOCK_PPM:
            return ""
        return (
            f"the device's own time goes at {ratio:.3g} times {self._by}, expected 1; if it is not simulated, its "
            f"sample period is not {self._feed.period:g} s: check its setting, or period_s in its address"
        )

    def _judge(self, rate: ClockRate, line_std: float) -> None:
        off, surely = off_period(rate), SIGNIFICANT_SIGMAS * math.hypot(rate.std * 1e-6, line_std)
        sentence = clock_sentence(self._feed.period, off, self._by)
        self.warning = sentence if abs(off) - surely > WARN_PERIOD_DEVIATION else ""
        self._refused = None
        if abs(off) - surely > MAX_PERIOD_DEVIATION and self._is_lasting(off):
            self._refused = DataRefused(
                self._feed.address.name, None, sentence, "the declared rate within 1 %",
                "check the sync line and the rate that the device is set to", ErrorCode.SAMPLE_RATE,
            )  # fmt: skip

    def _is_lasting(self, off: float) -> bool:
        """Return whether either half of the stamps, by itself, is off as far: a machine held up bends one only."""
        t, utc = np.array(self._stamps).T
        half = len(t) // 2
        halves = [fit_clock([(t[part], utc[part])]) for part in (slice(half), slice(half, None))]
        return all(one is not None and off_period(one) * np.sign(off) > MAX_PERIOD_DEVIATION for one in halves)

    def _take(self) -> None:
        if self._feed.stamp is None:
            return
        host_ns, device_s = self._feed.stamp
        counters = self._feed.stream.counters
        if (restarts := counters.restarts + counters.clock_jumps) > self._restarts:  # two stretches make no line
            self._restarts = restarts
            self._reset()
        if self._stamps and device_s <= self._stamps[-1][0]:
            if device_s < self._stamps[-1][0]:  # it restarted
                self._reset()
            return
        utc = self._times.of(host_ns, device_s, self._feed.pulse_age)
        if self._times.is_pulsed is not self.is_pulsed:  # readings and pulses make no one line
            self._stamps.clear()
            self.is_pulsed = self._times.is_pulsed
            self._by, self._span_s, self._scatter = PULSED if self.is_pulsed else self._read_by
        if utc is not None:
            self._stamps.append((device_s, utc))

    def _reset(self) -> None:
        self._stamps.clear()
        self._times.reset()


def host_sample_rate(feed: LiveFeed, every_s: float = EVERY_S) -> SampleRate:
    """Return the watch of a device by this machine's clock, which is right to about 1e-4."""
    by = "this machine's clock"
    return SampleRate(feed, lambda host_ns: host_ns / 1e9, by=by, span_s=SPAN_S, every_s=every_s)
