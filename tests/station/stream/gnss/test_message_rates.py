"""A message that comes much more rarely than it was asked for is named, whatever the autopilot answered."""

import re

import pytest

from drivers.address_parsing import parse_device_url
from drivers.mavlink.session import MavlinkSession
from drivers.simulated.companions.gnss_server import Autopilot
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from station.stream.gnss_feed import GnssFeed
from station.stream.reader import Chunk, StreamGap

REPORTED_S = 15.0  # 8 to ask for all of it, 5 to measure, and the way there
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

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        self.now += 0.05
        data = self._answer + self._autopilot.due(self.now)
        self._session.hear(data, self.now)
        self._answer = self._autopilot.hear(self._session.due(self.now), self.now)
        return [Chunk(round(self.now * 1e9), data)] if data else []


def heard(source: Asked, until_s: float) -> dict[str, float]:
    """Return what was said, and when first."""
    feed, reported = GnssFeed(source, clock=source.clock), dict[str, float]()
    while source.now < until_s:
        feed.advance()
        reported.setdefault(feed.trouble, source.now)
    return reported


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
    reported = heard(Asked(autopilot, faults), 40.0)
    reported.pop("")
    [(text, at)] = reported.items()
    assert re.search(r"GPS_RAW_INT comes at (0\.8|1|1\.2) Hz, 5 Hz was asked for", text)  # one more or less in 5 s
    assert "rate=1" in text
    assert at <= REPORTED_S


@pytest.mark.parametrize("rate_hz", [0.2, 5.0])
def test_a_rate_that_was_granted_is_not(rate_hz: float) -> None:
    assert set(heard(Asked(AutopilotTruth(default_hz=1.0), hz=rate_hz), 60.0)) == {""}
    slow = AutopilotTruth(default_hz=1.0, obeys=False)
    assert set(heard(Asked(slow, hz=1.0), 40.0)) == {""}  # what the words said to do


def test_a_message_that_stops_among_others_is_reported_and_so_is_its_end() -> None:
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
