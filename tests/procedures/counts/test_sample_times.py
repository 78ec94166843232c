"""Rows whose stamps are no times of samples: reads that bring many at once, late, shaken and rounded stamps."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from procedures.arrays import FloatArray
from procedures.counts.sample_times import StampsGoBack, log_times, own_period, sample_times
from tests.refusals import refused

PERIOD = 0.01006
ROWS = 3000


def in_bursts(true: FloatArray, least: int, most: int) -> FloatArray:
    """Stamp rows when a read brought them, some microseconds after another."""
    rng = np.random.default_rng(least)
    t, first = true.copy(), 0
    while first < len(t):
        last = min(first + int(rng.integers(least, most + 1)), len(t)) - 1
        t[first : last + 1] = true[last] + rng.exponential(1e-3) + 1e-5 * np.arange(last + 1 - first)
        first = last + 1
    return rising(t)


def rising(t: FloatArray) -> FloatArray:
    return np.maximum.accumulate(t) + 1e-7 * np.arange(len(t))


def shaken(true: FloatArray) -> FloatArray:
    return rising(true + 0.3 * PERIOD * np.random.default_rng(1).standard_normal(len(true)))


STAMPS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "as taken": lambda true: true,
    "in twos": lambda true: in_bursts(true, 2, 2),
    "one to three": lambda true: in_bursts(true, 1, 3),
    "four to twelve": lambda true: in_bursts(true, 4, 12),
    "in fifties": lambda true: in_bursts(true, 50, 50),
    "two to fifty": lambda true: in_bursts(true, 2, 50),
    "shaken": shaken,
    "to the millisecond": lambda true: np.round(true, 3),
    "to 8.4 ms": lambda true: rising(np.floor(true / 8.4e-3) * 8.4e-3),
}


@pytest.mark.parametrize("kind", STAMPS)
@pytest.mark.parametrize("lost", [(), (700,), (400, 1100, 2000)])
def test_the_mean_period_and_the_rows_lost_are_those_of_the_samples(kind: str, lost: tuple[int, ...]) -> None:
    taken = PERIOD * np.delete(np.arange(ROWS), [row + i for row in lost for i in range(5)])
    found = sample_times(STAMPS[kind](taken), 0.01)
    assert found.period == pytest.approx(PERIOD, rel=1e-3)
    gaps = np.flatnonzero(np.diff(taken) > 1.5 * PERIOD) + 1
    assert len(found.begins) == 1 + len(lost)
    assert np.all(np.abs(found.begins[1:] - gaps) <= 50)  # somewhere in its burst
    assert found.is_uneven == (kind not in {"as taken", "to the millisecond"})
    assert np.all(np.diff(found.t) > 0)


@pytest.mark.parametrize("kind", ["in twos", "four to twelve", "in fifties", "two to fifty"])
@pytest.mark.parametrize("missing", [300, 3000])
def test_a_period_near_the_stated_one_is_found_across_a_long_gap(kind: str, missing: int) -> None:
    taken = PERIOD * np.delete(np.arange(ROWS + missing), np.arange(1000, 1000 + missing))
    found = sample_times(STAMPS[kind](taken), 0.01)
    assert found.period == pytest.approx(PERIOD, rel=1e-3)
    assert len(found.begins) == 2
    assert abs(found.begins[1] - 1000) <= 50


def of_reads(true: FloatArray, every: float, delay: float, seed: int) -> FloatArray:
    """Stamp rows when reads at any phase of the sample period brought them, late by about ``delay`` [s]."""
    rng = np.random.default_rng(seed)
    due = np.arange(true[0], true[-1] + 3 * every, every) + rng.uniform(0, every)
    read = np.maximum.accumulate(due + rng.exponential(delay, len(due)))
    by = np.minimum(np.searchsorted(read, true), len(read) - 1)
    return np.asarray(read[by] + 2e-5 * (np.arange(len(true)) - np.searchsorted(by, by)))


@pytest.mark.parametrize(("every", "delay"), [(0.1, 0.005), (0.1, 0.001), (0.04, 0.01), (0.25, 0.05)])
def test_reads_of_any_phase_make_no_gap_and_hide_none(every: float, delay: float) -> None:
    for seed in range(40):
        found = sample_times(of_reads(0.02 * np.arange(1000), every, delay, seed), 0.02)
        assert len(found.begins) == 1
    for seed in range(10):
        lost = 0.02 * np.delete(np.arange(1005), np.arange(400, 405))
        found = sample_times(of_reads(lost, every, delay, seed), 0.02)
        assert np.any(np.abs(found.begins - 400) <= every / 0.02)


def test_rows_lost_one_by_one_from_even_stamps_are_gaps_each() -> None:
    rng = np.random.default_rng(2)
    kept = np.sort(rng.choice(ROWS, ROWS * 9 // 10, replace=False))
    found = sample_times(0.01 * kept, 0.01)
    assert not found.is_uneven
    assert len(found.begins) - 1 == np.count_nonzero(np.diff(kept) > 1)
    assert found.period == pytest.approx(0.01)


def test_a_period_is_found_where_quite_another_is_stated() -> None:
    for kind in ("as taken", "in twos", "in fifties", "shaken", "to the millisecond"):
        found = sample_times(STAMPS[kind](PERIOD * np.arange(ROWS)), 7 * PERIOD)
        assert found.period == pytest.approx(PERIOD, rel=2e-3)


@pytest.mark.parametrize("true", [0.05, 0.16, 0.2, 0.3])
def test_rows_of_a_lower_rate_than_stated_are_no_gaps(true: float) -> None:
    t = np.delete(np.arange(1000) * true, np.arange(300, 400))
    found = sample_times(t, 0.1)
    assert found.period == pytest.approx(true)
    assert found.begins.tolist() == [0, 300]


# Stamps as loggers write them


LOG_PERIOD = 0.01


@pytest.mark.parametrize(("word", "tick"), [(2.0**16, 1e-3), (2.0**32, 1e-6), (1e6, 1e-6), (60.0, 1.0)])
def test_a_counter_that_wraps_goes_on(word: float, tick: float) -> None:
    true = np.arange(40_000) * (word * tick / 9_000)
    stamps = np.floor(true / tick + 0.7 * word) % word if tick < 1 else (true / tick + 0.7 * word) % word
    found = log_times(stamps, tick)
    assert found.modulus == word
    assert found.wraps in {4, 5}
    assert found.t[-1] == pytest.approx(true[-1], abs=2 * tick)
    assert np.all(np.diff(found.t) > 0)


def test_a_modulus_of_no_round_number_is_found_where_it_returns() -> None:
    stamps = np.arange(5000) * LOG_PERIOD % 0.128  # STIM300: 0.128 s
    found = log_times(stamps, 1.0)
    assert found.t[-1] == pytest.approx(4999 * LOG_PERIOD, rel=1e-3)


def test_one_fall_by_no_modulus_is_refused_with_its_row() -> None:
    stamps = np.concatenate((np.arange(100) * LOG_PERIOD, np.arange(50) * LOG_PERIOD + 0.123))
    with refused(StampsGoBack, row=100):
        log_times(stamps, 1.0)


@pytest.mark.parametrize("burst", [2, 7, 32])
def test_rows_of_one_read_share_a_stamp_and_the_mean_rate_is_right(burst: int) -> None:
    rng = np.random.default_rng(burst)
    n = 20_000
    taken = np.arange(n) * LOG_PERIOD
    read = np.repeat(taken[burst - 1 :: burst], burst) + np.repeat(rng.uniform(0, LOG_PERIOD, n // burst), burst)
    found = log_times(np.round(read, 6), 1.0)
    assert np.all(np.diff(found.t) > 0)
    times = sample_times(found.t, own_period(found.t))
    assert times.period == pytest.approx(LOG_PERIOD, rel=3e-4)


def test_stamps_of_whole_milliseconds_at_1500_hz_keep_the_rate() -> None:
    found = log_times(np.floor(np.arange(30_000) / 1.5), 1e-3)
    assert own_period(found.t) == pytest.approx(1 / 1500, rel=1e-4)


def test_rows_a_little_out_of_order_stay_in_their_order() -> None:
    stamps = np.arange(2000) * LOG_PERIOD
    stamps[[500, 501]] = stamps[[501, 500]]
    found = log_times(stamps, 1.0)
    assert found.out_of_order == 1
    assert np.all(np.diff(found.t) > 0)
    assert own_period(found.t) == pytest.approx(LOG_PERIOD, rel=1e-4)


@pytest.mark.parametrize("length", [1, 2, 5])
def test_a_stamp_that_stood_still_is_no_gap(length: int) -> None:
    true = np.arange(2000) * LOG_PERIOD
    stamps = true.copy()
    for row in (0, 500, 1200):
        stamps[row : row + length + 1] = stamps[row]
    found = log_times(stamps, 1.0)
    assert found.t == pytest.approx(true)
    assert found.shared == 3 * length
    assert sample_times(found.t, LOG_PERIOD).begins.tolist() == [0]


@given(st.lists(st.floats(1e-3, 1.0), min_size=3, max_size=60))
def test_stamps_that_rise_are_left_as_they_are(steps: list[float]) -> None:
    stamps = np.cumsum(steps)
    assert log_times(stamps, 1.0).t == pytest.approx(stamps - stamps[0])
