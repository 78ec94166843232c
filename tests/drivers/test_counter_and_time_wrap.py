"""Counters that wrap are unwrapped, and breaks of the sequence are seen."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drivers.counter_and_time_wrap import CounterWatch, TimeWatch, unwrap, unwrap_steps
from procedures.counts.sample_records import CountBlock


def block(counter: list[int] | None = None, time: list[float] | None = None) -> CountBlock:
    n = len(counter if counter is not None else time or [])
    return CountBlock(
        counter=np.array(counter if counter is not None else [-1] * n, dtype=np.int64),
        device_time=np.array(time if time is not None else [np.nan] * n, dtype=float),
        gyro=np.zeros((n, 3), np.int64),
        accel=np.zeros((n, 3), np.int64),
        temperature=np.full(n, np.nan),
        status=np.zeros(n, np.int64),
        healthy=np.ones(n, np.bool_),
    )


@given(
    start=st.integers(0, 2**40),
    steps=st.lists(st.integers(-(2**15), 2**15 - 1), min_size=1, max_size=20),
    cut=st.integers(0, 20),
)
def test_unwrapping_gives_back_what_wrapped_in_blocks_of_any_size(start: int, steps: list[int], cut: int) -> None:
    true = start + 2**20 + np.cumsum([0, *steps])
    wrapped = true % 2**16
    head = unwrap(wrapped[: cut + 1], 2**16, last=int(true[0]))
    tail = unwrap(wrapped[cut + 1 :], 2**16, last=int(head[-1]))
    np.testing.assert_array_equal(np.concatenate((head, tail)), true)


def test_unwrapping_without_a_past_starts_at_the_first_counter() -> None:
    np.testing.assert_array_equal(unwrap(np.array([254, 255, 0, 2]), 256), [254, 255, 256, 258])
    assert len(unwrap(np.empty(0, np.int64), 256)) == 0


def test_a_wrap_is_no_jump_and_a_gap_across_it_is() -> None:
    watch = CounterWatch(256)
    assert watch.jumps(block([254, 255, 0, 1])) == 0
    assert watch.jumps(block([2, 4, 4, 3])) == 3
    assert watch.jumps(block([4])) == 0


def test_device_time_shows_gaps_repeats_and_steps_back() -> None:
    time = 100 + 0.005 * np.arange(60)
    watch = TimeWatch()
    assert watch.jumps(block(time=time[:20].tolist())) == 0
    assert watch.jumps(block(time=[*time[22:50], time[49], time[30]])) == 3  # one of them while it was learning
    assert watch.jumps(block(time=[np.nan])) == 1


def test_a_repeat_is_a_step_of_nothing_however_far_a_clock_that_wraps_has_gone() -> None:
    turn = 0.128
    ticks = np.arange(1, 200_001, 37) * 5e-4  # of the running time that the last frame had
    steps = unwrap_steps(ticks % turn - ticks, turn)
    assert np.array_equal(steps, np.zeros(len(ticks)))
    later = unwrap_steps((ticks + 0.02) % turn - ticks, turn)
    np.testing.assert_allclose(later, 0.02, atol=1e-7)
