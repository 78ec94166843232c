"""When a sample rate is fitted, when it is judged, and what begins it anew: looked at sample by sample."""

from types import SimpleNamespace
from typing import Any

import pytest

from procedures.counts.reference_time import ClockRate
from station.errors import DataRefused
from station.stream.gnss.sample_rate import SampleRate, host_sample_rate

STEP_S = 0.0505  # 100 samples last a little less than 5 s
NS = 10**9
EPOCH = 1.78e9


def feed_of(counters: SimpleNamespace) -> Any:
    stream, address = SimpleNamespace(counters=counters), SimpleNamespace(name="imu")
    return SimpleNamespace(stamp=None, pulse_age=None, period=0.005, address=address, stream=stream)


class Stream:
    """A device's newest sample, looked at a step apart; ``late_s`` is how much later UTC was when it was read."""

    def __init__(self, **settings: Any) -> None:
        counters = SimpleNamespace(restarts=0, clock_jumps=0)
        self.counters, self.host_s, self.device_s, self.now = counters, 0.0, 0.0, 0.0
        self.is_pulsed = False
        self.feed = feed_of(counters)
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


def test_a_rate_is_there_with_the_hundredth_sample() -> None:
    stream = Stream()
    assert stream.go(99) is None
    rate = stream.go(1)
    assert rate is not None
    assert abs(rate.ppm) < 1.0


def test_whatever_the_clock_reads_the_first_fit_is_made_at_once() -> None:
    stream = Stream()
    stream.go_unjudged(99)
    stream.watch.clock = lambda: 0.0
    assert stream.go(1) is not None
    assert not stream.watch.is_pulsed


def test_pulses_at_the_devices_own_input_err_by_nothing_and_are_no_machines_clock() -> None:
    by = "this machine's clock"
    stream = Stream(span_s=30.0, scatter=lambda: 1.0, by=by)
    stream.is_pulsed = True
    stream.go(100, off=2e-3)
    assert stream.watch.is_pulsed
    assert "by its reference pulses (PPS) a sample lasts 0.00500" in stream.watch.warning
    stream = Stream(span_s=30.0, by=by)
    stream.is_pulsed = True
    stream.go_unjudged(110, off=0.055)
    with pytest.raises(DataRefused, match="by its reference pulses"):
        stream.go(1, off=0.055)
    assert stream.watch.pace == ""


def test_a_sample_that_was_looked_at_counts_once() -> None:
    stream = Stream()
    stream.go(50)
    for _ in range(200):
        stream.now += STEP_S
        stream.watch.look()
    assert stream.watch.rate is None
    assert stream.go(49) is None
    assert stream.go(1) is not None


def test_before_a_sample_came_there_is_nothing_to_say() -> None:
    assert Stream().watch.warned() == ""


@pytest.mark.parametrize(("settings", "every_s"), [({}, 2.0), ({"every_s": 5.0}, 5.0)])
def test_it_is_fitted_again_after_so_long(settings: dict[str, float], every_s: float) -> None:
    stream = Stream(**settings)
    first, at = stream.go(100), stream.now
    while (again := stream.go(1)) is first:
        pass
    assert stream.now - at == pytest.approx(every_s, abs=STEP_S)
    assert stream.now - at >= every_s
    assert again is not None


def test_this_machines_clock_tells_no_rate_before_the_span_is_over() -> None:
    stream = Stream(span_s=12.0, every_s=0.0)
    while stream.go(1) is None:
        pass
    assert stream.device_s - STEP_S == pytest.approx(12.0, abs=STEP_S)


@pytest.mark.parametrize("counter", ["restarts", "clock_jumps"])
def test_a_device_that_began_anew_is_fitted_by_what_came_since(counter: str) -> None:
    stream = Stream(every_s=0.0)
    before = stream.go(100)
    setattr(stream.counters, counter, 1)
    stream.device_s += 3.0
    assert stream.go(99) is before
    after = stream.go(1)
    assert after is not before
    assert after is not None
    assert abs(after.ppm) < 1.0


def test_a_time_that_goes_back_is_a_new_beginning_without_being_counted() -> None:
    stream = Stream(every_s=0.0)
    before = stream.go(120)
    stream.device_s = 1.0
    assert stream.go(100) is before  # the one that went back is the sign alone
    after = stream.go(1)
    assert after is not before
    assert after is not None
    assert abs(after.ppm) < 1.0


@pytest.mark.parametrize(
    ("off", "samples", "scatter_s", "is_said"),
    [
        (2e-3, 1189, 7.2e-3, True), (2e-3, 1189, 7.8e-3, False),  # 60 s
        (1.5e-3, 5000, 12.0e-3, True), (1.5e-3, 5000, 13.2e-3, False),  # the newest 4000 are kept, of 202 s
    ],
)  # fmt: skip
def test_the_line_that_utc_is_read_from_may_be_off_at_both_ends(
    off: float, samples: int, scatter_s: float, *, is_said: bool
) -> None:
    """Four sigmas of two scatters over the span, beside what a rate is beyond 0.1 %."""
    stream = Stream(scatter=lambda: scatter_s)
    stream.go_unjudged(samples, off)
    stream.go(1, off)
    assert bool(stream.watch.warning) == is_said


def test_a_rate_that_is_off_and_then_right_is_no_longer_warned_of() -> None:
    stream = Stream(every_s=0.0)
    stream.go_unjudged(199, off=2e-3)
    stream.go(1, off=2e-3)
    assert stream.watch.said == stream.watch.warning == stream.watch.warned()
    assert stream.watch.said.startswith("clock.rate: by reference time a sample lasts 0.00501 s, +0.20% off")
    stream.counters.restarts += 1
    stream.go(100)
    assert stream.watch.said == ""


def test_a_refusal_stands_until_the_rate_is_right() -> None:
    stream = Stream(every_s=0.0)
    with pytest.raises(DataRefused):
        stream.go(100, off=0.02)
    with pytest.raises(DataRefused, match=r"imu: found clock\.rate.*expected the declared rate within 1 %"):
        stream.go(1, off=0.02)
    assert stream.watch.said == stream.watch.warned() != stream.watch.warning
    stream.counters.clock_jumps += 1
    with pytest.raises(DataRefused):
        stream.go(99)
    assert stream.watch.said
    stream.watch.warned()
    for _ in range(99):
        stream.host_s, stream.device_s = stream.host_s + STEP_S, stream.device_s + STEP_S
        stream.feed.stamp = round(stream.host_s * NS), stream.device_s
        stream.watch.warned()
    assert stream.watch.said == ""


@pytest.mark.parametrize("off", [0.05, -0.05])
@pytest.mark.parametrize("is_first", [True, False])
def test_what_bends_half_of_the_samples_alone_is_no_wrong_rate(off: float, *, is_first: bool) -> None:
    stream, whole = Stream(), Stream()
    stream.go_unjudged(500, off if is_first else 0.0)
    stream.go_unjudged(499, 0.0 if is_first else off)
    stream.go(1, 0.0 if is_first else off)
    assert "% off" in stream.watch.warning
    whole.go_unjudged(999, off)
    with pytest.raises(DataRefused):
        whole.go(1, off)


def test_another_pace_is_said_from_five_seconds_of_the_clock_on() -> None:
    stream = Stream(every_s=0.0, span_s=30.0, by="this machine's clock")
    stream.go(100, off=9.0)
    assert stream.watch.pace == ""
    stream.go(1, off=9.0)
    assert stream.watch.pace.startswith("the device's own time goes at 0.1 times this machine's clock, expected 1")
    assert stream.watch.said == stream.watch.pace


@pytest.mark.parametrize(("off", "is_said"), [(0.055, True), (0.045, False), (-0.055, True), (-0.045, False)])
def test_a_pace_is_another_beyond_a_twentieth_and_of_this_machines_clock_alone(
    off: float, *, is_said: bool
) -> None:
    stream = Stream(every_s=0.0, span_s=30.0)
    stream.go(110, off=1 / (1 + off) - 1)
    assert bool(stream.watch.pace) == is_said
    other = Stream()
    other.go_unjudged(110, off=1 / (1 + off) - 1)
    with pytest.raises(DataRefused):  # of a reference that is no machine's it is a wrong rate
        other.go(1, off=1 / (1 + off) - 1)
    assert other.watch.pace == ""


def test_by_this_machines_clock_a_wrong_rate_is_refused_after_half_a_minute() -> None:
    stream = Stream()
    stream.watch = host_sample_rate(stream.feed, every_s=0.0)
    stream.watch.clock = lambda: stream.now
    with pytest.raises(DataRefused, match=r"by this machine's clock a sample lasts 0\.0051 s") as refused:
        stream.go(1000, off=0.02)
    assert stream.device_s == pytest.approx(30.0, abs=2 * STEP_S)
    assert "check the sync line" in str(refused.value)
