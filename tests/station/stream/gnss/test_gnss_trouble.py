"""What is wrong with a receiver, to the tenth of a second at which it is said."""

import pytest

from drivers.device_url_parser import parse_device_url
from drivers.mavlink.decoder import MavlinkDecoder
from drivers.mavlink.signing import SignatureCheck
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.earth.gnss_records import FixType, GnssFix
from station.stream.gnss.gnss_trouble import GnssTrouble

LINK = "mavlink:udpin:127.0.0.1:14550"


def burst(system: int = 1) -> bytes:
    """Return one of each message of an autopilot."""
    return Autopilot(Truth(), AutopilotTruth(system=system)).due(0.0)


def fix(kind: FixType, satellites: int | None = None) -> GnssFix:
    return GnssFix("GPS_RAW_INT", 1, 0, kind, satellites=satellites)


class Watched:
    """A decoder, its watch, and the newest fix; the watch began at 0 s."""

    def __init__(self, query: str = "?rate=5", signatures: SignatureCheck | None = None) -> None:
        self.now = 0.0
        address = parse_device_url(LINK + query)
        self.decoder = MavlinkDecoder(address.system, signatures)
        self.watch = GnssTrouble(address, lambda: self.now)
        self.latest: GnssFix | None = None

    def at(self, now: float, data: bytes = b"") -> str:
        """Return what is said at a time, of bytes that came then too."""
        self.now = now
        self.decoder.feed(data, round(now * 1e9))
        return self.watch.look(self.decoder, self.latest)


def test_bytes_in_no_frame_are_said_after_so_long_and_no_longer_once_a_frame_comes() -> None:
    said = "no MAVLink frame"
    watched = Watched()
    assert watched.at(1.7) == ""
    assert said in watched.at(1.8)
    watched.latest = fix(FixType.FIX_3D)
    assert watched.at(2.0, burst()) == ""
    assert watched.at(3.7) == ""
    assert said in watched.at(3.85)


def test_frames_that_are_not_signed_are_what_is_wrong() -> None:
    watched = Watched(signatures=SignatureCheck(bytes(32)))
    watched.at(0.5, burst())
    refused = watched.decoder.framer.counters.refused
    assert refused > 0
    assert f"{refused} frames unsigned, 0 wrongly signed, 0 replayed" in watched.at(1.8)


@pytest.mark.parametrize(("query", "expected"), [("?system=1", "1"), ("", "an autopilot's heartbeat")])
def test_another_systems_frames_are_said_with_who_is_there(query: str, expected: str) -> None:
    watched = Watched(query)
    if not query:
        watched.decoder.feed(b"", 0)
        watched.decoder.system = 250  # one that was heard and is gone
    for now in (0.5, 1.0, 1.7):
        assert watched.at(now, burst(9) + burst(7)) == ""
    said = watched.at(1.8)
    assert f"system 7, 9 is there, expected {expected}" in said
    assert "system=N" in said


@pytest.mark.parametrize(("rate", "first_s"), [("5", 1.8), ("1", 3.0)])
def test_a_receiver_may_take_three_of_its_periods_for_its_first_fix(rate: str, first_s: float) -> None:
    watched = Watched(f"?rate={rate}")
    now = 0.0
    while now < first_s - 0.15:
        assert watched.at(now, burst()) == ""
        now += 0.1
    assert watched.at(first_s - 0.05, burst()) == ""
    assert "no GNSS message" in watched.at(first_s + 0.01, burst())


def test_a_fix_at_no_place_is_said_with_why() -> None:
    watched = Watched()
    watched.latest = GnssFix("GPS_INPUT", 1, 0, FixType.NO_FIX, no_place="latitude and longitude are exactly 0")
    assert "exactly 0" in watched.at(2.0, burst())
