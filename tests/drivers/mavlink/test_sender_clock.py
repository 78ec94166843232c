import pytest

from drivers.mavlink.fixes import SenderClock

S = 10**9
UTC = 1_780_000_000 * S  # 2026: in microseconds beyond 1e15, so no time since boot


def test_a_stamp_is_told_on_both_clocks_once_a_mark_has_joined_them() -> None:
    clock = SenderClock()
    assert clock.times(5_000_000) == (None, 5 * S)
    assert clock.times(UTC // 1000) == (UTC, None)
    assert clock.times(0) == (None, None)
    mark = clock.mark(host_ns=100 * S, boot_ns=40 * S, utc_ns=UTC)
    assert (mark.host_ns, mark.device_ns, mark.utc_ns) == (100 * S, 40 * S, UTC)
    assert clock.times(45_000_000) == (UTC + 5 * S, 45 * S)
    assert clock.times(UTC // 1000 + 3_000_000) == (UTC + 3 * S, 43 * S)
    assert clock.times(1) == (UTC - 40 * S + 1000, 1000)
    assert clock.times(10**15) == (UTC - 40 * S + 10**18, 10**18)


def test_latency_is_what_a_message_came_later_than_the_promptest_mark() -> None:
    clock = SenderClock()
    assert clock.latency(100 * S, 40 * S) is None
    clock.mark(100 * S, 40 * S, None)
    clock.mark(102 * S - S // 2, 41 * S, None)  # half a second late
    assert clock.latency(103 * S, 42 * S + S // 4) == pytest.approx(0.75)
    assert clock.latency(103 * S, None) is None


def test_a_boot_time_that_goes_back_by_more_than_a_second_is_a_restart() -> None:
    clock = SenderClock()
    clock.mark(100 * S, 40 * S, UTC)
    clock.mark(101 * S, 39 * S, None)  # out of order, no more
    assert (clock.reboots, clock.times(45_000_000)[0]) == (0, UTC + 5 * S)
    clock.mark(200 * S, 2 * S, None)
    assert (clock.reboots, clock.times(45_000_000)) == (1, (None, 45 * S))
    assert clock.latency(201 * S, 2 * S) == pytest.approx(1.0)  # by the new clock alone


def test_a_boot_time_of_32_bit_that_begins_anew_is_no_restart() -> None:
    clock = SenderClock()
    for ms in range(2**32 - 3000, 2**32 + 3000, 1000):
        boot_ns = clock.since_boot_ns(ms % 2**32)
        assert boot_ns == ms * 10**6
        clock.mark(boot_ns + 7, boot_ns, UTC + boot_ns)
        assert clock.since_boot_ns((ms - 200) % 2**32) == (ms - 200) * 10**6  # a fix of before the mark
        assert clock.times(boot_ns // 1000) == (UTC + boot_ns, boot_ns)
    assert clock.reboots == 0
    boot_ns = clock.since_boot_ns(100_000)  # no mark for minutes: it was switched off and on
    assert boot_ns == 100 * S
    clock.mark(0, boot_ns, None)
    assert clock.reboots == 1
