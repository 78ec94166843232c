"""Counts of a live feed as calibrated samples, each with its times and flags."""

from collections.abc import Callable
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import UNKNOWN
from procedures.counts.sample_records import CountBlock, SampleBlock
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.rates_and_forces import Sensors
from station.sending.outputs import CalibratedSamples, Quality
from station.stream.live.live_feed import LiveFeed
from station.stream.recorder.sample_times import RowTimes, SampleMoments, Utc

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

    def reset(self) -> None:
        """Forget what the device's clock was checked against: it may have restarted."""
        self._moments.reset()
        self._rows.reset()
        self._next_ns, self._pulsed = 0, None

    def of(self, t: FloatArray, read_ns: int, pulse_age: float | None) -> tuple[IntArray, FloatArray]:
        """Return moments (n,) [ns] and UTC (n,) [s] of samples at device times ``t`` (n,) [s] of one read.

        ``pulse_age`` is how long before the last of them a pulse came [s], None: not stated.
        """
        last = float(t[-1])
        if read_ns >= self._next_ns:
            self._next_ns = read_ns + LOOK_NS
            self._lag_ns = self._moments.of(last, read_ns) - round(last * 1e9)
        lag = min(self._lag_ns, read_ns - round(last * 1e9))
        taken = np.round(t * 1e9).astype(np.int64) + lag
        moment = self._rows.of(read_ns, last, pulse_age)
        if moment is not None and self._rows.is_pulsed:
            self._pulsed = moment - last
        elif not self._rows.is_pulsed:
            self._pulsed = None
        if self._pulsed is not None:
            self.is_by_messages = False
            return taken, t + self._pulsed
        by_messages = None if self._utc is None else self._utc(int(taken[-1]))
        self.is_by_messages = by_messages is not None
        return taken, t + (np.nan if by_messages is None else by_messages - last)


LOOK_S = 1.0  # of the station's time: how often the slow things are looked at, such as a constant channel


class LiveSamples:
    """Follows a feed that is identified; call `take` after each of its `advance`.

    ``C`` (3, 3) takes IMU axes to those asked for, ``utc`` gives UTC [s] of a moment [ns] or None, ``clock_off``
    says in words that the device's clock is off, empty where it is not.
    """

    def __init__(
        self, feed: LiveFeed, applied: AppliedCalibration, C: FloatArray, utc: Utc | None = None,
        clock_off: Callable[[], str] = lambda: "",
    ) -> None:  # fmt: skip
        self._feed, self._clock_off = feed, clock_off
        counts = feed.wire.output == "increments"
        self._sensors = Sensors(applied.document, applied.nominal, C, feed.period, counts=counts)
        self._times, self._document = SampleTimes(utc), applied.document or {}
        self._full = 2 ** (feed.wire.count_bits - 1) - 1 if counts else None
        self._lasting = _lasting(feed, applied)
        self._slow, self._next_look = Quality(0), 0.0
        self._at, self._begin = feed.buffer.first, -1
        self._counter: int | None = None  # of the sample before
        self.sent = self.lost = self.gaps = 0  # samples, missed by the device's counter, breaks and beginnings
        self.unsettled = 0  # samples that the calibration cannot undo
        self.device_s = 0.0  # s of the device's own time that have passed, what was lost meanwhile in it
        self._last_t = 0.0
        self.not_applied: tuple[str, ...] = ()

    def take(self, now: float) -> CalibratedSamples | None:
        """Return what has come since the last call, None if nothing; ``now`` [s] is the station's time."""
        buffer = self._feed.buffer
        first, last = max(self._at, buffer.first), buffer.end
        if first >= last or self._feed.stamp is None:
            return None
        self._at = last
        if is_restarted := buffer.begin != self._begin:
            self._begin, self._counter = buffer.begin, None
            self._times.reset()
        block = buffer.block(first, last)
        flags = self._flags(block, buffer.breaks(first, last) - first, is_restarted=is_restarted, now=now)
        taken, utc = self._times.of(block.device_time, buffer.host_ns(last - 1), self._feed.pulse_age)
        begin = block.device_time[0] - self._feed.period if is_restarted else self._last_t
        self._last_t = float(block.device_time[-1])
        self.device_s += self._last_t - float(begin)
        read = self._sensors.calibrated(block)
        self.not_applied = read.not_applied
        of_all = Quality.EFFECT_LEFT_IN if read.not_applied else Quality(0)
        of_all |= Quality.UTC_BY_MESSAGES if self._times.is_by_messages else Quality(0)
        sequence = np.arange(self.sent, self.sent + len(block))
        self.sent += len(block)
        known = np.isfinite(block.temperature)
        temperature: FloatArray = np.where(known, block.temperature, read.temperature)
        flags |= np.uint32(of_all | self._of_temperature(read.temperature))
        flags[read.unsettled] |= np.uint32(Quality.UNSETTLED)
        self.unsettled += int(np.count_nonzero(read.unsettled))
        force, rate, missed = read.found.force, read.found.rate, self._missed(block)
        return CalibratedSamples(sequence, block.device_time, utc, taken, force, rate, temperature, flags, missed)

    def _flags(
        self, block: SampleBlock, breaks: IntArray, *, is_restarted: bool, now: float
    ) -> NDArray[np.uint32]:
        flags = np.full(len(block), self._lasting | self._looked(now), dtype=np.uint32)
        flags[breaks] |= np.uint32(Quality.GAP_BEFORE)
        if is_restarted:
            flags[0] |= np.uint32(Quality.BEGUN_ANEW | Quality.GAP_BEFORE)
        if not self.sent:  # nothing was before it
            flags[0] &= ~np.uint32(Quality.GAP_BEFORE)
        self.gaps += int(np.count_nonzero(flags & Quality.GAP_BEFORE))
        flags[~block.healthy] |= np.uint32(Quality.DEVICE_DOUBTS)
        if isinstance(block, CountBlock) and self._full is not None:
            largest = np.abs(np.hstack((block.gyro, block.accel))).max(axis=1)
            flags[largest >= self._full] |= np.uint32(Quality.SATURATED)
        return flags

    def _looked(self, now: float) -> Quality:
        """Return what is looked at now and then only."""
        if now >= self._next_look:
            self._next_look = now + LOOK_S
            constant = Quality.CHANNEL_CONSTANT if self._feed.silent else Quality(0)
            self._slow = constant | (Quality.CLOCK_OFF if self._clock_off() else Quality(0))
        return self._slow

    def _of_temperature(self, temperature: float) -> Quality:
        if not np.isfinite(temperature):
            return Quality.TEMPERATURE_MISSING
        low, high = self._document.get("temperature_range_c") or (-np.inf, np.inf)
        return Quality(0) if low <= temperature <= high else Quality.TEMPERATURE_OUTSIDE

    def _missed(self, block: SampleBlock) -> IntArray:
        """Return how many samples the device's counter misses before each."""
        before = int(block.counter[0]) - 1 if self._counter is None else self._counter
        self._counter = int(block.counter[-1])
        missed: IntArray = np.maximum(np.diff(block.counter, prepend=before) - 1, 0)
        self.lost += int(missed.sum())
        return missed


def _lasting(feed: LiveFeed, applied: AppliedCalibration) -> Quality:
    """Return the flags that all samples of a run have."""
    document, unit, found = applied.document, feed.unit, Quality(0)
    if not feed.stream.decoder.kind.has_time:
        found |= Quality.TIME_BY_HOST
    if document is None:
        return found | Quality.NOMINAL_SCALE
    until = document.get("valid_until")
    expired = until is not None and datetime.fromisoformat(until) < datetime.now(UTC)
    if expired or document.get("status") != "calibrated":
        found |= Quality.CALIBRATION_DOUBTED
    if unit is None or UNKNOWN in {unit.model, unit.serial}:
        found |= Quality.UNIT_UNKNOWN
    return found
