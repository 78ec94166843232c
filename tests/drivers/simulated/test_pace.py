import pytest

from drivers.simulated.device import MAX_CHUNK_SAMPLES
from drivers.simulated.server import MAX_BEHIND_S, Pace


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_deadlines_are_absolute_and_a_late_wake_up_is_caught_up() -> None:
    clock = Clock()
    pace = Pace(2.0, 0.02, clock)
    assert pace.delay(100) == pytest.approx(1.0)
    clock.now += 1.1  # woke 0.1 s late
    assert pace.delay(105) == 0.0
    assert pace.delay(120) == pytest.approx(0.1)


def test_a_device_that_fell_far_behind_starts_its_pace_anew() -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    clock.now += 60.0
    assert pace.delay(50) == 0.0
    assert pace.delay(100) == pytest.approx(1.0)
    assert MAX_BEHIND_S < 60


def test_without_pace_nothing_waits_and_chunks_stay_small() -> None:
    assert Pace(0.0, 0.02, Clock()).delay(10**9) == 0.0
    assert Pace(0.0, 0.02, Clock()).samples == MAX_CHUNK_SAMPLES
    assert Pace(1e6, 0.02, Clock()).samples == MAX_CHUNK_SAMPLES


def test_a_device_at_its_own_pace_sends_each_sample_and_a_faster_one_several_at_a_time() -> None:
    assert Pace(1.0, 0.01, Clock()).samples == 1
    assert Pace(0.5, 0.01, Clock()).samples == 1
    assert Pace(10.0, 0.02, Clock()).samples == 20  # 0.04 s of the wall: 25 times a second, not 100


def test_a_device_held_up_on_purpose_goes_on_at_its_time() -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    pace.excuse(4.0)
    clock.now += 4.0
    assert pace.delay(1) == 0.0
    assert pace.delay(250) == pytest.approx(1.0)
    clock.now += 60.0  # once more, and not on purpose
    assert pace.delay(300) == 0.0
    assert pace.delay(350) == pytest.approx(1.0)


@pytest.mark.parametrize(("late_s", "next_s"), [(0.25, 0.75), (0.24, 0.76), (0.26, 1.0)])
def test_a_device_may_be_a_quarter_of_a_second_late(late_s: float, next_s: float) -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    clock.now += 2.0 + late_s
    assert pace.delay(100) == 0.0
    assert pace.delay(150) == pytest.approx(next_s)


@pytest.mark.parametrize(("late_s", "next_s"), [(4.2, -3.2), (4.3, 1.0)])
def test_what_was_excused_is_added_to_a_quarter_of_a_second(late_s: float, next_s: float) -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    pace.excuse(4.0)
    clock.now += late_s
    assert pace.delay(0) == 0.0
    assert pace.delay(50) == pytest.approx(max(0.0, next_s))


@pytest.mark.parametrize(
    ("speed", "period", "samples"),
    [(1.0, 0.001, 10), (1.0, 0.004, 2), (1.0, 0.5, 1), (2.0, 0.02, 4), (1.0, 1e-4, 50), (1.5, 0.03, 2)],
)
def test_a_chunk_is_of_ten_milliseconds_or_of_forty_when_faster_than_time(
    speed: float, period: float, samples: int
) -> None:
    assert Pace(speed, period, Clock()).samples == samples


def test_what_was_excused_is_over_when_the_device_has_caught_up() -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    pace.excuse(4.0)
    assert pace.delay(0) == 0.0
    clock.now += 1.0  # late, and not on purpose
    assert pace.delay(0) == 0.0
    assert pace.delay(50) == pytest.approx(1.0)
