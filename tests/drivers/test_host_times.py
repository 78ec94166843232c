"""Times of a device that sends none: as good as the host can tell, whatever the reads do."""

import numpy as np
import pytest

from drivers.host_times import HostTimes

PERIOD = 0.0025


def arrivals(
    seed: int, seconds: float, *, jitter: float = 3e-4, ppm: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return true times and arrivals of frames, 4 to a read, each read late by an exponential."""
    rng = np.random.default_rng(seed)
    n = int(seconds / PERIOD)
    true = PERIOD * (1 + ppm * 1e-6) * np.arange(1, n + 1)
    read = np.arange(3, n, 4)
    return true, np.maximum.accumulate(true[read] + rng.exponential(jitter, len(read)) + 1e-4)


def timed(host: HostTimes, arrival: np.ndarray, size: int = 4) -> np.ndarray:
    return np.concatenate([host.take(float(a), np.ones(size, np.int64)) for a in arrival])


@pytest.mark.parametrize("seed", range(5))
def test_a_dwell_is_as_long_as_it_was_to_30_ppm(seed: int) -> None:
    true, arrival = arrivals(seed, 130.0, ppm=200.0)
    host = HostTimes()
    times = timed(host, arrival)
    first, last = int(20 / PERIOD), int(120 / PERIOD)
    assert times[last] - times[first] == pytest.approx(true[last] - true[first], rel=3e-5)
    assert np.abs(times[first:] - true[first : len(times)]).max() < PERIOD / 2
    assert host.period == pytest.approx(PERIOD * 1.0002, rel=3e-3)
    steps = np.diff(times[first:])
    assert (steps > 0).all()
    assert steps.max() < 1.5 * PERIOD, "steering is no break"


def test_frames_that_are_lost_show_as_one_step() -> None:
    _, arrival = arrivals(1, 60.0)
    lost = np.concatenate((arrival[:4000], arrival[4002:]))  # 8 frames
    steps = np.diff(timed(HostTimes(), lost))[int(10 / PERIOD) :]
    (jump,) = steps[steps > 1.5 * PERIOD]
    assert jump == pytest.approx(9 * PERIOD, abs=0.7 * PERIOD)


def test_frames_that_nobody_sent_turn_time_back() -> None:
    _, arrival = arrivals(1, 60.0)
    more = np.sort(np.concatenate((arrival, arrival[4000:4003] + 1e-5)))
    steps = np.diff(timed(HostTimes(), more))
    assert (steps < 0).sum() == 1


@pytest.mark.parametrize("seconds", [0.2, 2.0, 5.0])
def test_a_backlog_that_is_read_at_once_is_no_loss(seconds: float) -> None:
    _, arrival = arrivals(2, 60.0)
    late = np.where((arrival > 30) & (arrival < 30 + seconds), 30 + seconds, arrival)
    steps = np.diff(timed(HostTimes(), late))[int(10 / PERIOD) :]
    assert steps.max() < 1.5 * PERIOD
    assert steps.min() > 0


def test_a_machine_that_is_held_up_now_and_then_breaks_nothing() -> None:
    rng = np.random.default_rng(3)
    _, arrival = arrivals(3, 120.0)
    for at in rng.uniform(10, 110, 40):
        held = (arrival > at) & (arrival < at + 0.1)
        arrival[held] = at + 0.1
    steps = np.diff(timed(HostTimes(), np.maximum.accumulate(arrival)))[int(10 / PERIOD) :]
    assert steps.max() < 1.5 * PERIOD
    assert steps.min() > 0


def test_the_period_is_known_after_three_seconds_and_not_before() -> None:
    host, known = HostTimes(), list[float]()
    for a in arrivals(4, 6.0)[1]:
        host.take(float(a), np.ones(4, np.int64))
        if host.is_reset:
            known.append(float(a))
    assert len(known) == 1
    assert 3.0 <= known[0] < 3.1
