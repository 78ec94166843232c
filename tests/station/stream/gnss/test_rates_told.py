"""How often messages come: counted one by one, judged by shares of what was asked for."""

import pytest

from station.stream.gnss.message_rates import MessageRates

FIX, TIME, OTHER = "GPS_RAW_INT", "SYSTEM_TIME", "VFR_HUD"
SETTLED_S = 13.0  # 8 s until all was asked for, and a window of 5 s


class Counted:
    """Rates of a receiver asked for 5 Hz, by a clock that is set."""

    def __init__(self, asked_hz: float = 5.0) -> None:
        self.now = 0.0
        self.rates = MessageRates("gnss", asked_hz, lambda: self.now)

    def came(self, at: float, count: int, name: str = FIX) -> None:
        self.now = at
        for _ in range(count):
            self.rates.came(name)

    def look(self, at: float, *, is_well: bool = True) -> str:
        self.now = at
        self.rates.look(is_well=is_well)
        return self.rates.trouble


def test_a_rate_is_that_of_the_last_five_seconds() -> None:
    counted = Counted()
    for at, count in ((0.0, 100), (1.0, 3), (4.0, 7)):
        counted.came(at, count)
    counted.came(4.0, 5, TIME)
    counted.now = 6.0
    assert counted.rates.hz() == {FIX: pytest.approx(2.0), TIME: pytest.approx(1.0)}
    assert counted.rates.hz(2.0) == {FIX: pytest.approx(3.5), TIME: pytest.approx(2.5)}
    counted.now = 6.01
    assert counted.rates.hz()[FIX] == pytest.approx(7 / 5)
    counted.now = 20.0
    assert counted.rates.hz() == {}


def test_the_newest_messages_are_counted_up_to_a_number() -> None:
    counted = Counted()
    counted.came(0.0, 7000)
    assert counted.rates.hz() == {FIX: pytest.approx(6000 / 5)}


@pytest.mark.parametrize(("count", "is_slow"), [(14, True), (15, False), (16, False), (0, True)])
def test_a_message_is_slow_below_three_fifths_of_what_was_asked_for(count: int, *, is_slow: bool) -> None:
    counted = Counted()
    counted.came(1.0, 1)
    counted.came(10.0, count)
    assert bool(counted.look(14.0)) == is_slow


@pytest.mark.parametrize(("count", "is_slow"), [(17, True), (18, False)])
def test_a_slow_message_is_well_again_beyond_seven_tenths(count: int, *, is_slow: bool) -> None:
    counted = Counted()
    counted.came(10.0, 10)
    said = counted.look(14.0)
    assert said == (
        "gnss: GPS_RAW_INT comes at 2 Hz, 5 Hz was asked for; let autopilot and receiver send it as often, "
        "or ask for less: rate=2 in the address"
    )
    counted.came(20.0, count)
    assert counted.look(24.0) == (said if is_slow else "")


@pytest.mark.parametrize("at", [12.95, 13.05])
def test_nothing_is_slow_until_all_was_asked_for_and_counted(at: float) -> None:
    counted = Counted()
    counted.came(at - 1.0, 5)
    assert bool(counted.look(at)) == (at > SETTLED_S)


def test_what_is_wrong_otherwise_begins_the_wait_anew_and_ends_what_was_slow() -> None:
    counted = Counted()
    counted.came(19.0, 5)
    assert "comes at 1 Hz" in counted.look(20.0)
    assert counted.look(20.5, is_well=False) == ""
    counted.came(33.0, 5)
    assert counted.look(33.45) == ""
    assert "comes at 1 Hz" in counted.look(33.55)


def test_a_low_rate_is_counted_for_as_long_as_five_messages_take() -> None:
    counted = Counted(0.5)
    for at in (10.0, 14.0):
        counted.came(at, 1)
    assert counted.look(17.95) == ""  # 8 s and ten
    assert "comes at 0.2 Hz, 0.5 Hz was asked for" in counted.look(18.05)
    for at in (16.0, 17.5, 19.0, 20.0):
        counted.came(at, 1)
    assert counted.look(20.05) == ""


def test_a_rate_of_almost_nothing_is_not_asked_for() -> None:
    counted = Counted(1.0)
    counted.came(12.0, 1)
    assert "comes at 0.2 Hz, 1 Hz was asked for" in counted.look(14.0)
    slow = Counted(0.1)  # a window of 50 s
    slow.came(50.0, 2)
    assert slow.look(60.0).endswith("rate=0.1 in the address")


def test_a_message_that_never_came_is_none_of_the_senders_and_one_that_no_longer_does_is() -> None:
    counted = Counted()
    counted.came(10.0, 25)
    assert counted.look(14.0) == ""  # the sender has no SYSTEM_TIME
    counted.came(14.0, 1, TIME)
    counted.came(19.0, 25)
    assert counted.look(19.5) == (
        "gnss: SYSTEM_TIME no longer comes, 5 Hz was asked for; check receiver and autopilot"
    )


def test_of_two_that_are_slow_the_position_is_named_and_others_are_not_watched() -> None:
    counted = Counted()
    for name in (OTHER, TIME, FIX):
        counted.came(13.0, 5, name)
    assert "GPS_RAW_INT comes" in counted.look(14.0)
    counted.came(17.0, 25)
    assert "SYSTEM_TIME comes at 1 Hz" in counted.look(17.5)
    counted.came(17.6, 20, TIME)
    assert counted.look(17.7) == ""
