"""Stamps as loggers write them: wrapping counters, one stamp for a read, rows out of order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from procedures.counts.log_stamps import StampsGoBack, log_times
from procedures.counts.sample_times import own_period, sample_times
from tests.refusals import refused

PERIOD = 0.01


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
    stamps = np.arange(5000) * PERIOD % 0.128  # STIM300: 0.128 s
    found = log_times(stamps, 1.0)
    assert found.t[-1] == pytest.approx(4999 * PERIOD, rel=1e-3)


def test_one_fall_by_no_modulus_is_refused_with_its_row() -> None:
    stamps = np.concatenate((np.arange(100) * PERIOD, np.arange(50) * PERIOD + 0.123))
    with refused(StampsGoBack, row=100):
        log_times(stamps, 1.0)


@pytest.mark.parametrize("burst", [2, 7, 32])
def test_rows_of_one_read_share_a_stamp_and_the_mean_rate_is_right(burst: int) -> None:
    rng = np.random.default_rng(burst)
    n = 20_000
    taken = np.arange(n) * PERIOD
    read = np.repeat(taken[burst - 1 :: burst], burst) + np.repeat(rng.uniform(0, PERIOD, n // burst), burst)
    found = log_times(np.round(read, 6), 1.0)
    assert np.all(np.diff(found.t) > 0)
    times = sample_times(found.t, own_period(found.t))
    assert times.period == pytest.approx(PERIOD, rel=3e-4)


def test_stamps_of_whole_milliseconds_at_1500_hz_keep_the_rate() -> None:
    found = log_times(np.floor(np.arange(30_000) / 1.5), 1e-3)
    assert own_period(found.t) == pytest.approx(1 / 1500, rel=1e-4)


def test_rows_a_little_out_of_order_stay_in_their_order() -> None:
    stamps = np.arange(2000) * PERIOD
    stamps[[500, 501]] = stamps[[501, 500]]
    found = log_times(stamps, 1.0)
    assert found.out_of_order == 1
    assert np.all(np.diff(found.t) > 0)
    assert own_period(found.t) == pytest.approx(PERIOD, rel=1e-4)


@given(st.lists(st.floats(1e-3, 1.0), min_size=3, max_size=60))
def test_stamps_that_rise_are_left_as_they_are(steps: list[float]) -> None:
    stamps = np.cumsum(steps)
    assert log_times(stamps, 1.0).t == pytest.approx(stamps - stamps[0])
