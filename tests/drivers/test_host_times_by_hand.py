"""Times of a device that sends none, on arrivals reckoned by hand: eight samples each eighth of a second."""

import numpy as np
import pytest

from drivers.host_times import HostTimes

PERIOD = 1 / 64
EIGHT = np.ones(8, np.int64)
KNOWN = 67.0  # s: learnt from 64 s on


def learnt() -> HostTimes:
    """Return one that has learnt the period from arrivals that are never late; its last sample is of 67 s."""
    host = HostTimes()
    for k in range(24):
        host.take(64.0 + k / 8, EIGHT)
        assert host.period is None
        assert not host.is_anew
    times = host.take(KNOWN, EIGHT)
    assert host.is_anew
    assert times == pytest.approx(KNOWN + PERIOD * np.arange(-7, 1))
    return host


def fed(host: HostTimes, late: list[float], first: int = 1) -> list[tuple[int, bool]]:
    """Return by how many samples each eighth of a second begins after the last one's end, and whether it stepped.

    ``late`` is how late each is read, in samples.
    """
    found = list[tuple[int, bool]]()
    last = KNOWN if first == 1 else np.nan
    for k, samples in enumerate(late, first):
        times = host.take(KNOWN + k / 8 + samples * PERIOD, EIGHT)
        step = (times[0] - last) / PERIOD
        found.append((round(step) if np.isfinite(step) else 1, host.has_stepped))
        last = float(times[-1])
    return found


PLAIN = (1, False)


def test_until_the_period_is_known_samples_are_spread_evenly() -> None:
    host = HostTimes()
    assert host.take(100.0, np.ones(4, np.int64)) == pytest.approx(100 + 1e-6 * np.arange(-3, 1), abs=1e-9)
    assert host.take(100.5, np.ones(5, np.int64)) == pytest.approx([100.1, 100.2, 100.3, 100.4, 100.5], abs=1e-9)
    assert host.take(100.5, np.ones(2, np.int64)) == pytest.approx([100.500001, 100.500002], abs=1e-9)
    assert host.take(101.0, np.ones(1, np.int64)) == pytest.approx([101.0], abs=1e-9)


def test_the_period_is_known_after_three_seconds() -> None:
    assert learnt().period == pytest.approx(PERIOD, rel=1e-9)


def test_the_period_is_known_after_33_samples_and_not_before() -> None:
    host, one = HostTimes(), np.ones(1, np.int64)
    for k in range(33):
        host.take(64.0 + k / 8, one)
        assert host.period is None
    host.take(64.0 + 33 / 8, one)
    assert host.period == pytest.approx(1 / 8)


def test_samples_of_a_sequence_that_is_counted_are_as_many_as_it_says() -> None:
    host, two = HostTimes(), np.array([2])
    for k in range(24):
        host.take(64.0 + k / 8, two)
    times = host.take(67.0, two)
    assert host.period == pytest.approx(1 / 16)
    assert times == pytest.approx([67.0])
    times = host.take(67.5, np.array([1, 3, 2, 2]))
    assert times == pytest.approx([67.0625, 67.25, 67.375, 67.5])


def test_the_period_is_learnt_from_more_than_three_half_seconds() -> None:
    """Arrivals lie in the half seconds 0, 6, 7 and 8 from the first; three of them are not enough."""
    host, known = HostTimes(), list[bool]()
    index = 0
    for at in (0.125, 3.25, 3.375, 3.625, 4.25):
        n = round(at * 64) - index
        index += n
        host.take(64.0 + at, np.ones(n, np.int64))
        known.append(host.period is not None)
    assert known == [False, False, False, False, True]
    assert host.period == pytest.approx(PERIOD)


@pytest.mark.parametrize("on_time", [0, 1, 2, 3])
def test_what_is_late_now_and_then_is_left_out_of_the_period(on_time: int) -> None:
    """Of four reads in half a second one is on time, the others ever later."""
    host = HostTimes()
    for k in range(25):
        host.take(64.0 + k / 8 + (0.0 if k % 4 == on_time or k == 0 else 0.02 + 0.001 * k), EIGHT)
    assert host.period == pytest.approx(PERIOD, rel=1e-9)


def test_the_period_is_the_straight_line_through_each_half_seconds_least_late() -> None:
    host = HostTimes()
    late = {0: 0.0, 1: 0.002, 2: 0.001, 3: 0.0, 4: 0.002, 5: 0.004}  # s, of the reads k = 4 w + 2
    for k in range(25):
        is_least = k % 4 == 2 and 0 < k // 4 < 6
        host.take(64.0 + k / 8 + (late[k // 4] if is_least else 0.0 if k in {0, 24} else 0.02), EIGHT)
    least = [0, *(4 * w + 2 for w in range(1, 6))]
    slope = np.polyfit(least, [k / 8 + late[w] for w, k in enumerate(least)], 1)[0]
    assert host.period == pytest.approx(slope / 8, rel=1e-9)


def test_a_beginning_anew_keeps_the_period() -> None:
    host = learnt()
    host.begin_anew()
    times = host.take(90.0, np.array([1, 2]))
    assert times == pytest.approx([90.0 - 2 * PERIOD, 90.0])
    assert not host.is_anew
    assert host.period == pytest.approx(PERIOD, rel=1e-9)


def test_a_quarter_of_a_sample_is_steered_out_by_thirty_and_five_hundredths() -> None:
    """The half second from 67.5 s on is late: 0.3 of it goes to the time, 0.1 per second to the pace."""
    host = learnt()
    assert fed(host, [0.25] * 7) == [PLAIN] * 7
    assert host.period == pytest.approx(PERIOD, rel=1e-9)  # the first half second had one that was not late
    before = host.take(68.0 + 0.25 * PERIOD, EIGHT)[-1]
    period = host.period
    assert period == pytest.approx(PERIOD * (1 + 0.1 * 0.25 * PERIOD), rel=1e-9)
    assert host.take(68.125, EIGHT)[0] - before == pytest.approx(0.3 * 0.25 * PERIOD + period, rel=1e-9)


@pytest.mark.parametrize(("late", "step"), [(2.0, 3), (5.2, 6), (0.7, 2), (0.5, 1)])
def test_samples_that_stay_late_for_two_half_seconds_were_lost(late: float, step: int) -> None:
    """Half seconds end at 67.5, 68 and 68.5 s; but for the first they are late throughout."""
    found = fed(learnt(), [late] * 16)
    stepped = [k for k, (_, has_stepped) in enumerate(found, 1) if has_stepped]
    assert stepped == ([12] if step > 1 else [])
    assert [each for each, _ in found[:12]] == [1] * 12
    assert found[12:] == [(step, False), PLAIN, PLAIN, PLAIN]


@pytest.mark.parametrize(("early", "step"), [(2.0, -1), (1.0, 0), (0.5, 1)])
def test_samples_that_stay_early_were_never_sent(early: float, step: int) -> None:
    """Half seconds end with the fifth and the ninth; both have none but early ones."""
    found = fed(learnt(), [-early] * 12)
    stepped = [k for k, (_, has_stepped) in enumerate(found, 1) if has_stepped]
    assert stepped == ([9] if step < 1 else [])
    assert [each for each, _ in found] == [1] * 9 + [step, 1, 1]


@pytest.mark.parametrize(("second", "third", "at"), [(2.0, 4.0, 12), (4.0, 2.0, 13)])
def test_the_lesser_of_two_half_seconds_says_how_many_were_lost(second: float, third: float, at: int) -> None:
    """What comes nearer its time than those before ends its half second an eighth later."""
    found = fed(learnt(), [second] * 8 + [third] * 6)
    assert [k for k, (_, has_stepped) in enumerate(found, 1) if has_stepped] == [at]
    assert found[at] == (3, False)


def test_one_late_half_second_is_no_loss() -> None:
    found = fed(learnt(), [2.0] * 8 + [0.0] * 16 + [2.0] * 7)
    assert found == [PLAIN] * 31


def test_late_and_then_early_is_neither() -> None:
    found = fed(learnt(), [2.0] * 8 + [-2.0] * 5)
    assert found == [PLAIN] * 13


def test_what_was_late_before_says_nothing_about_two_early_half_seconds() -> None:
    found = fed(learnt(), [2.0] * 8 + [-2.0] * 11)
    assert [k for k, (_, has_stepped) in enumerate(found, 1) if has_stepped] == [17]
    assert found[17:] == [(-1, False), PLAIN]


def test_after_a_silence_that_ended_on_time_two_half_seconds_tell() -> None:
    host = learnt()
    host.begin_anew()
    host.take(80.0, EIGHT)
    stepped = list[int]()
    for k in range(1, 11):
        host.take(80.0 + k / 8 - 2 * PERIOD, EIGHT)
        stepped += [k] * host.has_stepped
    assert stepped == [9]


def test_after_a_silence_the_first_that_comes_counts_as_a_half_second() -> None:
    host = learnt()
    host.begin_anew()
    host.take(80.0, EIGHT)
    assert not host.has_stepped
    host.take(80.75, np.ones(46, np.int64))  # two samples less than in 0.75 s
    assert not host.has_stepped
    stepped = list[bool]()
    for k in range(1, 6):
        host.take(80.75 + k / 8, EIGHT)
        stepped.append(host.has_stepped)
    assert stepped == [False, False, False, True, False]


def test_half_a_second_is_no_silence() -> None:
    host = learnt()
    host.take(KNOWN + 0.5, np.ones(30, np.int64))  # two samples less; the window still holds what was not late
    stepped = list[bool]()
    for k in range(1, 9):
        host.take(KNOWN + 0.5 + k / 8, EIGHT)
        stepped.append(host.has_stepped)
    assert stepped == [False] * 7 + [True]
