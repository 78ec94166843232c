"""A message that comes much more rarely than it was asked for is named, whatever the autopilot answered."""

import re

import pytest

from drivers.device_url_parser import parse_device_url
from drivers.mavlink.session import MavlinkSession
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.timed_faults import TimedFault
from drivers.simulated.truth import Truth
from station.stream.gnss.gnss_feed import GnssFeed
from station.stream.gnss.message_rates import MessageRates
from station.stream.reader import Chunk, GapMark

TOLD_S = 15.0  # 8 to ask for all of it, 5 to measure, and the way there
LINK = "mavlink:udpin:127.0.0.1:14550"


class Asked:
    """An autopilot that the station's session talks to, both in memory; each poll is a twentieth of a second."""

    def __init__(self, autopilot: AutopilotTruth, faults: tuple[TimedFault, ...] = (), hz: float = 5.0) -> None:
        self.address = parse_device_url(f"{LINK}?rate={hz:g}")
        self.now = 0.0
        self._session = MavlinkSession(hz)
        self._autopilot = Autopilot(Truth(), autopilot, faults)
        self._answer = b""

    def clock(self) -> float:
        return self.now

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        self.now += 0.05
        data = self._answer + self._autopilot.due(self.now)
        self._session.hear(data, self.now)
        self._answer = self._autopilot.hear(self._session.due(self.now), self.now)
        return [Chunk(round(self.now * 1e9), data)] if data else []


def heard(source: Asked, until_s: float) -> dict[str, float]:
    """Return what was said, and when first."""
    feed, said = GnssFeed(source, clock=source.clock), dict[str, float]()
    while source.now < until_s:
        feed.advance()
        said.setdefault(feed.trouble, source.now)
    return said


DEAF = (TimedFault("deaf", 0.0, 1e6),)


@pytest.mark.parametrize(
    ("autopilot", "faults"),
    [
        (AutopilotTruth(default_hz=1.0, obeys=False), ()),  # accepted, and nothing came of it
        (AutopilotTruth(default_hz=1.0, obeys=False, knows_intervals=False), ()),  # refused, the old way too
        (AutopilotTruth(default_hz=1.0, obeys=False), DEAF),  # ignored
    ],
    ids=["ignored", "unsupported", "no answer"],
)
def test_a_rate_that_was_not_granted_is_named_with_what_to_do(
    autopilot: AutopilotTruth, faults: tuple[TimedFault, ...]
) -> None:
    said = heard(Asked(autopilot, faults), 40.0)
    said.pop("")
    [(text, at)] = said.items()
    assert re.search(r"GPS_RAW_INT comes at (0\.8|1|1\.2) Hz, 5 Hz was asked for", text)  # one more or less in 5 s
    assert "rate=1" in text
    assert at <= TOLD_S


@pytest.mark.parametrize("rate_hz", [0.2, 5.0])
def test_a_rate_that_was_granted_is_not(rate_hz: float) -> None:
    assert set(heard(Asked(AutopilotTruth(default_hz=1.0), hz=rate_hz), 60.0)) == {""}
    slow = AutopilotTruth(default_hz=1.0, obeys=False)
    assert set(heard(Asked(slow, hz=1.0), 40.0)) == {""}  # what the words said to do


def test_a_message_that_stops_among_others_is_told_and_so_is_its_end() -> None:
    source = Asked(AutopilotTruth(default_hz=5.0))
    feed = GnssFeed(source, clock=source.clock)
    while source.now < 20.0:
        feed.advance()
    assert feed.trouble == ""
    source._autopilot._set_interval(24, float("inf"), source.now)  # noqa: SLF001
    while source.now < 26.0:
        feed.advance()
    assert "GPS_RAW_INT no longer comes, 5 Hz was asked for; check receiver" in feed.trouble
    source._autopilot._set_interval(24, 0.2, source.now)  # noqa: SLF001
    while source.now < 32.0:
        feed.advance()
    assert feed.trouble == ""


FIX, TIME = "GPS_RAW_INT", "SYSTEM_TIME"


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


@pytest.mark.parametrize(("count", "is_slow"), [(14, True), (15, False), (0, True)])
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
    assert all(word in said for word in ("GPS_RAW_INT", "2 Hz", "5 Hz", "rate=2"))
    counted.came(20.0, count)
    assert counted.look(24.0) == (said if is_slow else "")


def test_a_message_that_never_came_is_none_of_the_senders_and_one_that_no_longer_does_is() -> None:
    counted = Counted()
    counted.came(10.0, 25)
    assert counted.look(14.0) == ""  # the sender has no SYSTEM_TIME
    counted.came(14.0, 1, TIME)
    counted.came(19.0, 25)
    assert "SYSTEM_TIME no longer comes" in counted.look(19.5)
