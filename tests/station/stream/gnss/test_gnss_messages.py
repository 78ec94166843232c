"""A receiver's own messages: what they make of site, time, files, and what is said when something is wrong."""

import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.address_parsing import parse_device_url
from drivers.mavlink.frames import SignatureCheck
from drivers.mavlink.gnss_fixes import MavlinkDecoder
from drivers.simulated.companions.gnss_server import Autopilot
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.gnss_records import FixType, GnssFix
from station.files.mcap_files.gnss_file import FixWriter
from station.stream.gnss_feed import GnssFeed, GnssTrouble
from station.stream.reader import Chunk, StreamGap

LINK = "mavlink:udpin:127.0.0.1:14550"
NS = 10**9
UTC_S = 1_780_000_000
MICRO = 10**6
AUTOPILOT, RECEIVER = 3, 0  # MAV_AUTOPILOT, ..._GENERIC


class Reported:
    """Messages of an autopilot, read at the moments at which they are said."""

    def __init__(self, url: str = LINK) -> None:
        self.address = parse_device_url(url)
        self.now, self.up_to_ns = 0.0, 0
        self._mav = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
        self._items = list[Chunk | StreamGap]()
        self.say(dialect.MAVLink_heartbeat_message(2, AUTOPILOT, 0, 0, 4, 3))

    def clock(self) -> float:
        return self.now

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        items, self._items = self._items, []
        return items

    def say(self, *messages: "dialect.MAVLink_message") -> None:
        for message in messages:
            self.send(bytes(message.pack(self._mav)))
            self._mav.seq = (self._mav.seq + 1) % 256

    def send(self, data: bytes) -> None:
        self._items.append(Chunk(round(self.now * NS), data))

    def mark(self, reason: str, *, is_open: bool) -> None:
        self._items.append(StreamGap(round(self.now * NS), reason, is_open))

    def lose(self, frames: int) -> None:
        self._mav.seq = (self._mav.seq + frames) % 256


def raw(stamp_us: int, fix: int = 3, latitude: float = 48.0) -> "dialect.MAVLink_message":
    """Return GPS_RAW_INT at a latitude [deg], 11 deg east, 500 m up, 1 sigma 2 m and 3 m."""
    place = round(latitude * 1e7), round(11.0 * 1e7), 500_000
    return dialect.MAVLink_gps_raw_int_message(
        stamp_us, fix, *place, 100, 100, 0, 0, 9, alt_ellipsoid=540_000, h_acc=2000, v_acc=3000
    )


def second(stamp_us: int, latitude: float = 49.0) -> "dialect.MAVLink_message":
    """Return the same of another antenna."""
    place = round(latitude * 1e7), round(11.0 * 1e7), 500_000
    return dialect.MAVLink_gps2_raw_message(
        stamp_us, 3, *place, 100, 100, 0, 0, 9, 0, 0, alt_ellipsoid=540_000, h_acc=2000, v_acc=3000
    )


def filtered(boot_ms: int) -> "dialect.MAVLink_message":
    return dialect.MAVLink_global_position_int_message(boot_ms, 500_000_000, 110_000_000, 500_000, 0, 0, 0, 0, 0)


def system_time(unix_us: int, boot_ms: int) -> "dialect.MAVLink_message":
    return dialect.MAVLink_system_time_message(unix_us, boot_ms)


def feed_of(noticed: Reported, writer: FixWriter | None = None) -> GnssFeed:
    return GnssFeed(noticed, writer, noticed.clock)


def test_the_site_is_that_of_the_first_antenna() -> None:
    noticed = Reported()
    feed = feed_of(noticed)
    noticed.say(second(MICRO))
    feed.advance()
    site = feed.site()
    assert site is not None
    assert round(site.latitude * 57.29578, 3) == 49.0  # none but the second has said anything
    noticed.say(*(raw(MICRO * i) for i in range(2)), *(second(MICRO * i) for i in range(5)))
    feed.advance()
    site = feed.site()
    assert site is not None
    assert (round(site.latitude * 57.29578, 3), site.fixes) == (48.0, 2)


def test_a_filtered_position_is_handed_on_and_is_no_fix() -> None:
    noticed = Reported()
    feed = feed_of(noticed)
    noticed.say(filtered(1000), raw(MICRO), filtered(2000))
    feed.advance()
    assert [fix.source for fix in feed.fixes] == ["GPS_RAW_INT"]
    assert feed.latest is feed.fixes[0]
    assert [fix.source for fix in feed.take(NS) if isinstance(fix, GnssFix)] == [
        "GLOBAL_POSITION_INT", "GPS_RAW_INT", "GLOBAL_POSITION_INT",
    ]  # fmt: skip
    assert feed.stream().rate_hz == pytest.approx(2 / 5.0)  # of the message that came most often


def utc_of(*, states_time: bool, fix: int = 3) -> tuple[GnssFeed, float | None]:
    """Return what the feed takes for UTC after 20 s: stamps of fixes are 0.3 s early, a stated time is exact."""
    noticed = Reported()
    feed = feed_of(noticed)
    for i in range(20):
        noticed.now = float(i)
        noticed.say(raw((UTC_S + i) * MICRO - 300_000, fix))
        if states_time and i >= 10:
            noticed.say(system_time((UTC_S + i) * MICRO, 1000 * i))
        feed.advance()
    return feed, feed.utc(20 * NS)


def test_a_stated_time_is_utc_and_the_stamps_of_fixes_are_where_there_is_none() -> None:
    _, stated = utc_of(states_time=True)
    assert stated == pytest.approx(UTC_S + 20.0, abs=1e-3)
    feed, stamped = utc_of(states_time=False)
    assert stamped == pytest.approx(UTC_S + 19.7, abs=1e-3)
    assert feed.utc_scatter() < 1e-3
    _, nowhere = utc_of(states_time=False, fix=1)
    assert nowhere is None


def test_its_health_and_its_summary_count_what_came_and_what_did_not() -> None:
    noticed = Reported()
    feed = feed_of(noticed)
    assert feed.stream().rate_hz == 0.0
    for i in range(10):
        noticed.now = 0.2 * i
        noticed.say(raw((UTC_S + i) * MICRO), *([system_time((UTC_S + i) * MICRO, 200 * i)] if i % 2 else []))
        feed.advance()
    noticed.lose(3)
    noticed.say(dialect.MAVLink_heartbeat_message(2, AUTOPILOT, 0, 0, 4, 3))
    noticed.send(b"\x00\x01\x02")
    noticed.now += 0.5
    feed.advance()
    state = feed.stream()
    assert (state.samples, state.gaps, state.lost, state.bad, state.trouble) == (10, 0, 3, 0, "")
    assert state.rate_hz == pytest.approx(2.0)
    assert state.age_s == pytest.approx(0.5)
    reported = (
        "10 fixes",
        "48.000000, 11.000000 deg, 540.0 m",
        "SYSTEM_TIME 1.0 Hz",
        "3 lost",
        "3 bytes in no frame",
    )
    assert all(words in feed.summary for words in reported)
    noticed.now += 1.9
    feed.advance()
    assert "no bytes for 1.8 s" in feed.trouble
    assert feed.stream().trouble == feed.trouble


def test_a_port_that_is_away_is_reported_before_what_is_missing_therefore() -> None:
    noticed = Reported()
    feed = feed_of(noticed)
    noticed.mark("port lost: gone", is_open=False)
    feed.advance()
    noticed.now = 5.0
    feed.advance()
    assert feed.trouble.endswith("port lost: gone; it is tried again and again: check cable and power")
    noticed.mark("port back", is_open=True)
    noticed.say(raw(MICRO), dialect.MAVLink_heartbeat_message(2, AUTOPILOT, 0, 0, 4, 3))
    feed.advance()
    assert feed.trouble == ""


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


@pytest.mark.parametrize(("rate", "first_s"), [("5", 1.8), ("1", 3.0)])
def test_a_receiver_may_take_three_of_its_periods_for_its_first_fix(rate: str, first_s: float) -> None:
    watched = Watched(f"?rate={rate}")
    now = 0.0
    while now < first_s - 0.15:
        assert watched.at(now, burst()) == ""
        now += 0.1
    assert watched.at(first_s - 0.05, burst()) == ""
    assert "no GNSS message" in watched.at(first_s + 0.01, burst())


def test_a_fix_at_no_place_is_reported_with_why() -> None:
    watched = Watched()
    watched.latest = GnssFix("GPS_INPUT", 1, 0, FixType.NO_FIX, no_place="latitude and longitude are exactly 0")
    assert "exactly 0" in watched.at(2.0, burst())
