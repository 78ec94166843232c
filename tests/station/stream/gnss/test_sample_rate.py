"""The device's own time against GNSS time, in its own pace."""

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from station.errors import DataRefused
from station.stream.gnss.sample_rate import SampleRate

NS = 10**9


def watch(off: float, seconds: float, jitter: float = 2e-3, pulses_s: float = 0.0, **settings: Any) -> SampleRate:
    """Return a watch that looked at a stream whose samples last ``off`` (relative) longer than it says.

    A pulse at each whole second is told until ``pulses_s`` [s].
    """
    rng = np.random.default_rng(1)
    stream = SimpleNamespace(counters=SimpleNamespace(restarts=0, clock_jumps=0))
    feed = SimpleNamespace(
        stamp=None, pulse_age=None, period=0.005, address=SimpleNamespace(name="imu"), stream=stream
    )
    rate = SampleRate(feed, lambda host_ns: 1.78e9 + host_ns / NS + jitter * rng.standard_normal(), **settings)  # type: ignore[arg-type]
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
    assert "clock.rate: by reference time a sample lasts 0.00501" in watch(2e-3, 60.0).warning
    assert watch(2e-3, 12.0, jitter=0.2).warning == ""  # too noisy to say so yet


def test_a_sync_line_at_another_rate_is_refused() -> None:
    with pytest.raises(DataRefused, match=r"3\.[89]\d% off .* sync line"):
        watch(0.039, 60.0)


def test_quite_another_pace_than_this_machines_is_said_and_ends_nothing() -> None:
    other = watch(9.0, 10.0, span_s=30.0, by="this machine's clock")
    assert "goes at 0.1 times this machine's clock, expected 1" in other.warned()
    assert "sample period is not 0.005 s" in other.warned()
    assert watch(1e-4, 60.0, span_s=30.0).warned() == ""


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
