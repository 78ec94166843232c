"""The sample rate that a device states, held against GNSS time, pulses and this machine's clock."""

import itertools
from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from procedures.counts.reference_time import ClockRate
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.stream.sample_rate import SampleRate, host_sample_rate
from tests.refusals import refused

STEP_S = 0.0505  # 100 samples last a little less than 5 s
NS = 10**9
EPOCH = 1.78e9


def feed_of(period: float) -> Any:
    counters = SimpleNamespace(restarts=0, clock_jumps=0)
    stream, address = SimpleNamespace(counters=counters), SimpleNamespace(name="imu")
    return SimpleNamespace(stamp=None, pulse_age=None, period=period, address=address, stream=stream)


class Stream:
    """A device's newest sample, looked at a step apart."""

    def __init__(self, **settings: Any) -> None:
        self.host_s, self.device_s, self.now, self.is_pulsed = 0.0, 0.0, 0.0, False
        self.feed = feed_of(0.005)
        self.counters = self.feed.stream.counters
        settings.setdefault("utc", lambda host_ns: EPOCH + host_ns / NS)
        self.watch = SampleRate(self.feed, **settings)
        self.watch.clock = lambda: self.now

    def go(self, samples: int, off: float = 0.0) -> ClockRate | None:
        """Look at so many, each of which lasts ``off`` (relative) longer than it says."""
        for _ in range(samples):
            self.host_s += STEP_S
            self.device_s += STEP_S / (1 + off)
            self.now += STEP_S
            self.feed.stamp = round(self.host_s * NS), self.device_s
            self.feed.pulse_age = (self.host_s % 1.0) / (1 + off) if self.is_pulsed else None
            self.watch.look()
        return self.watch.rate

    def go_unjudged(self, samples: int, off: float = 0.0) -> None:
        """The same before it is time for a fit."""
        self.watch.clock = lambda: -1.0
        self.go(samples, off)
        self.watch.clock = lambda: self.now


def watch(off: float, seconds: float, jitter: float = 2e-3, pulses_s: float = 0.0, **settings: Any) -> SampleRate:
    """Return a watch that looked at a stream whose samples last ``off`` (relative) longer than it says.

    A pulse at each whole second is told until ``pulses_s`` [s].
    """
    rng, feed = np.random.default_rng(1), feed_of(0.005)
    rate = SampleRate(feed, lambda host_ns: EPOCH + host_ns / NS + jitter * rng.standard_normal(), **settings)
    clock = itertools.count(0.0, 0.06)
    rate.clock = lambda: float(next(clock))
    for host in np.arange(0.1, seconds, 0.06):
        feed.stamp = round(host * NS), host / (1 + off)
        feed.pulse_age = (host % 1.0) / (1 + off) if host < pulses_s else None
        rate.look()
    return rate


def test_a_rate_that_is_right_is_left_alone() -> None:
    right = watch(5e-4, 60.0)
    assert right.warning == ""
    assert right.rate is not None
    assert abs(right.rate.ppm + 5e-4 * 1e6) < 4 * right.rate.std + 1


def test_more_than_a_thousandth_off_is_a_warning_that_names_the_clock() -> None:
    reported = watch(2e-3, 60.0).warning
    assert "clock.rate" in reported
    assert "0.00501" in reported
    assert watch(2e-3, 12.0, jitter=0.2).warning == ""  # too noisy to say so yet


def test_a_sync_line_at_another_rate_is_refused() -> None:
    with refused(DataRefused, ErrorCode.SAMPLE_RATE, file="imu"):
        watch(0.039, 60.0)


def test_when_the_pulses_stop_readings_alone_are_the_reference_again() -> None:
    late = watch(0.0, 40.0, jitter=0.03, pulses_s=12.0, span_s=5.0, by="this machine's clock")
    assert not late.is_pulsed
    assert late.rate is not None
    assert abs(late.rate.ppm) < 4 * late.rate.std
    assert late.rate.std > 10.0  # of 30 ms in 25 s, not of pulses
    lasting = watch(0.0, 40.0, jitter=0.03, pulses_s=40.0, span_s=5.0)
    assert lasting.is_pulsed
    assert lasting.rate is not None
    assert lasting.rate.std < 1.0


def test_pulses_at_the_devices_own_input_err_by_nothing() -> None:
    stream = Stream(span_s=30.0, scatter=lambda: 1.0, by="this machine's clock")
    stream.is_pulsed = True
    stream.go(100, off=2e-3)
    assert stream.watch.is_pulsed
    assert "PPS" in stream.watch.warning
    stream = Stream(span_s=30.0, by="this machine's clock")
    stream.is_pulsed = True
    stream.go_unjudged(110, off=0.055)
    with refused(DataRefused, ErrorCode.SAMPLE_RATE):  # though this machine's clock may go at another pace
        stream.go(1, off=0.055)


@pytest.mark.parametrize("counter", ["restarts", ""])
def test_a_device_that_began_again_is_fitted_by_what_came_since(counter: str) -> None:
    stream = Stream(every_s=0.0)
    before = stream.go(120)
    if counter:
        setattr(stream.counters, counter, 1)
        stream.device_s += 3.0
    else:
        stream.device_s = 1.0  # its time goes back
        stream.go(1)
    assert stream.go(99) is before
    after = stream.go(1)
    assert after is not before
    assert after is not None
    assert abs(after.ppm) < 1.0


def test_a_refusal_stands_until_the_rate_is_right() -> None:
    stream = Stream(every_s=0.0)
    for samples in (100, 1):
        with refused(DataRefused, ErrorCode.SAMPLE_RATE, file="imu"):
            stream.go(samples, off=0.02)
    stream.counters.clock_jumps += 1
    for _ in range(100):
        with suppress(DataRefused):
            stream.go(1)
    assert stream.watch.warned() == ""


@pytest.mark.parametrize("off", [0.05, -0.05])
def test_what_bends_half_of_the_samples_alone_is_no_wrong_rate(off: float) -> None:
    stream, whole = Stream(), Stream()
    stream.go_unjudged(500, off)
    stream.go_unjudged(499)
    stream.go(1)
    assert "% off" in stream.watch.warning
    whole.go_unjudged(999, off)
    with refused(DataRefused, ErrorCode.SAMPLE_RATE):
        whole.go(1, off)


@pytest.mark.parametrize(("off", "is_reported"), [(0.055, True), (0.045, False), (-0.055, True), (-0.045, False)])
def test_a_pace_is_another_beyond_a_twentieth_and_of_this_machines_clock_alone(
    off: float, *, is_reported: bool
) -> None:
    stream = Stream(every_s=0.0, span_s=30.0)
    stream.go(110, off=1 / (1 + off) - 1)
    assert bool(stream.watch.pace) == is_reported
    other = Stream()
    other.go_unjudged(110, off=1 / (1 + off) - 1)
    with refused(DataRefused, ErrorCode.SAMPLE_RATE):  # of a reference that is no machine's it is a wrong rate
        other.go(1, off=1 / (1 + off) - 1)
    assert other.watch.pace == ""


def test_by_this_machines_clock_a_wrong_rate_is_refused_after_half_a_minute() -> None:
    stream = Stream()
    stream.watch = host_sample_rate(stream.feed, every_s=0.0)
    stream.watch.clock = lambda: stream.now
    with refused(DataRefused, ErrorCode.SAMPLE_RATE, "0.0051 s"):
        stream.go(1000, off=0.02)
    assert stream.device_s == pytest.approx(30.0, abs=2 * STEP_S)
