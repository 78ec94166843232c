"""When a fix was valid: by the IMU's clock and by UTC, with clocks of their own rates, late reads, restarts."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.gnss_records import FixType, GnssFix, TimeMark
from station.stream.gnss_fix_times import FixTimes, UtcLine

EPOCH = 1_780_000_000 * 10**9


def clocks(seconds: float, span_ns: int | None = None, boot: float = 50.0) -> FixTimes:
    """Return marks of an IMU 30 ppm fast and a sender 20 ppm slow, read within 4 ms, some 200 ms late."""
    rng, times = np.random.default_rng(1), FixTimes(span_ns)
    for t in np.arange(0.0, seconds, 0.1).tolist():
        late = rng.uniform(0.0, 0.004) + 0.2 * (rng.random() < 0.1)
        times.stamp_imu(EPOCH + round((t + late) * 1e9), 7.0 + t * (1 + 30e-6))
        late = rng.uniform(0.0, 0.004) + 0.2 * (rng.random() < 0.1)
        times.stamp_sender(TimeMark(EPOCH + round((t + late) * 1e9), round((boot + t * (1 - 20e-6)) * 1e9), None))
    return times


def fix(true: float, boot: float | None = 50.0, read: float = 0.3) -> GnssFix:
    device = None if boot is None else round((boot + true * (1 - 20e-6)) * 1e9)
    return GnssFix("GPS_RAW_INT", 1, EPOCH + round((true + read) * 1e9), FixType.FIX_3D, device_ns=device)


def test_a_fix_is_placed_by_its_senders_clock_however_late_it_was_read() -> None:
    times = clocks(60.0, 20 * 10**9)
    for true in (45.0, 59.0):
        for read in (0.05, 0.9):
            assert times.of(fix(true, read=read)) == pytest.approx(7.0 + true * (1 + 30e-6), abs=0.003)
    assert times.knows_sender


def test_without_the_senders_clock_the_moment_of_reading_must_do() -> None:
    times = clocks(60.0)
    assert times.of(fix(50.0, boot=None, read=0.12)) == pytest.approx(57.12, abs=0.006)


def test_nothing_is_reported_before_the_clocks_are_known() -> None:
    assert FixTimes().of(fix(1.0)) is None
    assert clocks(0.3).of(fix(0.2)) is None


def test_a_sender_that_restarts_is_learnt_again() -> None:
    times = clocks(30.0)
    for t in np.arange(30.0, 40.0, 0.1).tolist():
        times.stamp_imu(EPOCH + round(t * 1e9), 7.0 + t)
        times.stamp_sender(TimeMark(EPOCH + round(t * 1e9), round((t - 29.0) * 1e9), None))
    restarted = GnssFix("GPS_RAW_INT", 1, EPOCH + round(38.0 * 1e9), FixType.FIX_3D, device_ns=round(8.5 * 1e9))
    assert times.of(restarted) == pytest.approx(7.0 + 37.5, abs=0.005)


@pytest.mark.parametrize("set_by", [0.3, 1e6, -5.0])
def test_a_clock_that_is_set_while_it_runs_makes_no_stamp_wrong(set_by: float) -> None:
    times, read = FixTimes(60 * 10**9, in_order=True), list[tuple[float, GnssFix]]()
    for t in np.arange(0.0, 60.0, 0.1).tolist():
        host_ns, device_ns = EPOCH + round(t * 1e9), round((1e7 + t - 0.03 + (set_by if t > 40 else 0.0)) * 1e9)
        times.stamp_imu(host_ns, 7.0 + t)
        times.stamp_sender(TimeMark(host_ns, device_ns, None))
        image = GnssFix("image", 1, host_ns, FixType.FIX_3D, device_ns=device_ns)
        read.append((7.0 + t, image))
        if t > 1.0:
            assert times.of(image) == pytest.approx(7.0 + t, abs=0.005)
    for at, image in read:  # each by the clock of its time
        assert times.of(image) == pytest.approx(at, abs=0.005)


@pytest.mark.parametrize("slow", [-1e-4, 1e-4])
def test_marks_that_lag_say_nothing_of_a_clock_in_order(slow: float) -> None:
    times, off = FixTimes(60 * 10**9, in_order=True), list[float]()
    for t in np.arange(0.0, 90.0, 0.1).tolist():
        times.stamp_imu(EPOCH + round(t * 1e9), 7.0 + t)
        late = 0.01 if t < 20.0 or t > 80.0 else 1.5 + 0.5 * np.sin(t)
        host_ns, device_ns = EPOCH + round((t + late) * 1e9), round((50.0 + t * (1 - slow)) * 1e9)
        times.stamp_sender(TimeMark(host_ns, device_ns, None))
        at = times.of(GnssFix("GPS_RAW_INT", 1, host_ns, FixType.FIX_3D, device_ns=device_ns))
        if t > 5.0 and at is not None:
            off.append(at - 7.0 - t)
    assert len(off) > 800
    assert np.abs(off).max() < 0.02


def test_an_imu_whose_time_restarts_is_not_placed_by_its_old_time() -> None:
    times = FixTimes(20 * 10**9)
    for t in np.arange(0.0, 5.0, 0.1).tolist():
        times.stamp_imu(EPOCH + round(t * 1e9), 7.0 + t)
    assert times.of(fix(4.0, boot=None)) == pytest.approx(11.3, abs=0.001)
    times.reset()
    times.stamp_imu(EPOCH + round(4.95 * 1e9), 0.0)
    assert times.of(fix(4.7, boot=None)) is None


@pytest.mark.parametrize("read", [0.05, 0.24])
def test_a_fix_with_utc_is_placed_by_the_pulses_at_the_imus_input(read: float) -> None:
    """The pulses come at whole seconds of UTC; boot time is told 80 ms wrong, or not at all."""
    times = clocks(60.0)
    for second in range(60):
        times.stamp_pulse(7.0 + second * (1 + 30e-6))
    for boot in (50.08, None):
        for true in (12.3, 41.98, 58.999):
            noticed = replace(fix(true, boot, read), utc_ns=EPOCH + round(true * 1e9))
            assert times.of(noticed) == pytest.approx(7.0 + true * (1 + 30e-6), abs=1e-4)
    without = replace(fix(12.3, None, read), utc_ns=None)
    assert times.of(without) == pytest.approx(19.3 + read, abs=0.006)
    far = replace(fix(12.3, None, 0.6), utc_ns=EPOCH + round(12.3 * 1e9))  # which second, nobody could tell
    assert times.of(far) == pytest.approx(19.3 + 0.6, abs=0.006)
    times.reset()
    assert not times.all_by_pulse


HOST, UTC = 5_000 * 10**9, 1_780_000_000 * 10**9
RATE = 1 + 50e-6


def marked(seconds: float, begin: float = 0.0, step_s: float = 0.0) -> UtcLine:
    """Return a line with ten marks a second, each read up to 2 ms late; ``step_s`` is added after 60 s."""
    line, rng = UtcLine(), np.random.default_rng(1)
    for t in np.arange(begin, begin + seconds, 0.1).tolist():
        later = step_s if t >= 60.0 else 0.0
        line.mark(HOST + round((t + rng.uniform(0.0, 0.002)) * 1e9), UTC + round((t * RATE + later) * 1e9))
    return line


@pytest.mark.parametrize("t", [5.0, 61.5, 110.0])
def test_utc_is_read_off_the_marks_around_a_moment(t: float) -> None:
    utc = marked(120.0).utc(HOST + round(t * 1e9))
    assert utc == pytest.approx(UTC / 1e9 + t * RATE, abs=0.001)


def test_a_moment_an_hour_on_is_not_determined_by_marks_of_the_first_minutes() -> None:
    line = marked(60.0)
    assert line.utc(HOST + 3600 * 10**9) is None
    assert line.utc(HOST) is not None


def test_marks_of_another_time_do_not_shift_it() -> None:
    line = marked(180.0, step_s=7.0)
    assert line.utc(HOST + 20 * 10**9) == pytest.approx(UTC / 1e9 + 20 * RATE, abs=0.001)
    assert line.utc(HOST + 160 * 10**9) == pytest.approx(UTC / 1e9 + 160 * RATE + 7.0, abs=0.001)


def test_without_marks_nothing_is_determined_and_their_scatter_is_that_of_the_reading() -> None:
    line = UtcLine()
    assert (line.utc(HOST), line.scatter) == (None, 0.0)
    line = marked(60.0)
    line.utc(HOST + 30 * 10**9)
    assert 2e-4 < line.scatter < 2e-3  # uniform over 2 ms: 0.58 ms
    line.reset()
    assert line.utc(HOST + 45 * 10**9) is None
