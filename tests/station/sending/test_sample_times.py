"""UTC of samples: by a receiver's messages, by a pulse that the device tells of, and neither."""

import numpy as np
import pytest

from station.sending.sample_times import SampleTimes

EPOCH = 1_780_000_000.0  # s since 1970 at device time 0
LINK = 0.003  # s that the link adds to every read


def read_ns(t: float, late: float = 0.0) -> int:
    return round((EPOCH + t + LINK + late) * 1e9)


def test_nothing_tells_utc_and_moments_follow_the_reads_that_came_least_late() -> None:
    times = SampleTimes(None)
    rng = np.random.default_rng(1)
    for first in np.arange(0.0, 3.0, 0.01):
        t = first + np.array([0.001, 0.002, 0.003])
        taken, utc = times.of(t, read_ns(t[-1], rng.exponential(0.02)), None)
        assert np.isnan(utc).all()
    assert taken / 1e9 == pytest.approx(EPOCH + t + LINK, abs=0.005)
    assert not times.is_by_messages


def test_a_receiver_tells_utc_by_its_messages() -> None:
    times = SampleTimes(lambda host_ns: host_ns / 1e9 - 100.0)
    _, utc = times.of(np.array([1.0, 1.5]), read_ns(1.5), None)
    assert utc == pytest.approx(EPOCH + np.array([1.0, 1.5]) + LINK - 100.0, abs=1e-6)
    assert times.is_by_messages


def test_a_pulse_tells_utc_however_late_reads_are_and_its_end_is_seen() -> None:
    times = SampleTimes(lambda host_ns: host_ns / 1e9)
    rng = np.random.default_rng(2)
    for first in np.arange(0.25, 8.0, 0.1):
        t = first + np.array([0.0, 0.05])
        age = float(t[-1] % 1.0)  # a second of UTC begins with one of the device's here
        _, utc = times.of(t, read_ns(t[-1], rng.exponential(0.05)), age)
        assert utc == pytest.approx(EPOCH + t, abs=1e-6)
        assert not times.is_by_messages
    for first in np.arange(8.0, 14.0, 0.1):
        t = first + np.array([0.0, 0.05])
        _, utc = times.of(t, read_ns(t[-1]), None)
    assert times.is_by_messages
    assert utc == pytest.approx(EPOCH + t, abs=0.01)


def test_a_restart_of_the_device_forgets_which_second_its_pulses_were() -> None:
    times = SampleTimes(lambda host_ns: host_ns / 1e9)
    times.of(np.array([200.25]), read_ns(200.25), 0.25)
    times.begin_anew()  # it counts from 0 again
    _, utc = times.of(np.array([2.25]), read_ns(202.25), 0.25)
    assert utc == pytest.approx(EPOCH + 202.25, abs=1e-6)
