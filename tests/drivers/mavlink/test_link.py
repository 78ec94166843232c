"""The simulated autopilot on real transports, opened by URL as the station does."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from drivers.address_parsing import parse_device_url
from drivers.mavlink.frames import GLOBAL_POSITION_INT, GPS2_RAW, SignatureCheck, read_key
from drivers.mavlink.gnss_fixes import MavlinkDecoder, Record
from drivers.mavlink.session import MavlinkPort
from drivers.ports import open_port
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import EPOCH_UTC, AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.gnss_records import AirData, Ambient, GnssFix, TimeMark, averaged_site
from tests.patience import HANG_S

KEY = bytes(range(100, 132))
TRUTH = Truth(latitude_deg=-33.5, longitude_deg=179.99999, height_m=120.0)


class Listener:
    """Reads a URL until something is true, as the reader process does."""

    def __init__(self, url: str) -> None:
        address = parse_device_url(url)
        check = SignatureCheck(read_key(address.key_file)) if address.key_file else None
        self.decoder = MavlinkDecoder(address.system, check)
        port = open_port(address)
        assert isinstance(port, MavlinkPort)
        self.port = port
        self.records: list[Record] = []

    def until(self, done: Callable[[], bool]) -> None:
        deadline = time.monotonic() + HANG_S
        while not done():
            assert time.monotonic() < deadline, (self.decoder.framer.counters, self.decoder.messages)
            self.records += self.decoder.feed(self.port.read(65536), time.monotonic_ns())

    def fixes(self, source: str = "GPS_RAW_INT") -> list[GnssFix]:
        return [one for one in self.records if isinstance(one, GnssFix) and one.source == source]


@pytest.mark.parametrize("transport", ["udp", "udp to us", "tcp", "pty"])
def test_every_transport_brings_all_messages_at_the_rate_asked_for(transport: str, free_udp_port: int) -> None:
    to = ("127.0.0.1", free_udp_port) if transport == "udp to us" else None
    with SimulatedGnss(TRUTH, transport=transport.split()[0], to=to, speed=20.0) as gnss:
        heard = Listener(f"{gnss.url}?rate=4")
        heard.until(lambda: len(heard.port.session.asked) == 6 and bool(heard.fixes()))
        assert {one.outcome for one in heard.port.session.asked} == {"accepted"}
        began = heard.fixes()[-1].device_ns
        heard.until(lambda: len(heard.fixes()) > 60)
        heard.port.close()
    fixes = heard.fixes()
    assert began is not None
    times = [fix.device_ns for fix in fixes if fix.device_ns is not None and fix.device_ns > began]
    assert 1e9 / np.median(np.diff(times)) == pytest.approx(4.0, rel=0.01)
    assert {type(one) for one in heard.records} >= {GnssFix, TimeMark, AirData, Ambient}
    assert heard.fixes("GPS2_RAW")
    assert all(fix.is_filtered for fix in heard.fixes("GLOBAL_POSITION_INT"))
    counters = heard.decoder.framer.counters
    assert (counters.bad_crc, counters.lost, counters.skipped_bytes) == (0, 0, 0)
    assert gnss.failure is None


def test_the_averaged_site_is_the_truth_within_its_own_sigma_across_the_date_line() -> None:
    with SimulatedGnss(TRUTH, speed=50.0, seed=3) as gnss:
        heard = Listener(gnss.url)
        heard.until(lambda: len(heard.fixes()) > 200)
        heard.port.close()
    site = averaged_site(heard.fixes())
    assert site is not None
    assert site.height is not None
    assert site.vertical_std is not None
    assert site.is_ellipsoidal
    north = (site.latitude - np.radians(-33.5)) * 6.37e6
    east = np.radians((np.degrees(site.longitude) - 179.99999 + 180) % 360 - 180) * 6.37e6 * np.cos(site.latitude)
    assert np.hypot(north, east) < 4 * site.horizontal_std
    assert abs(site.height - 120.0) < 4 * site.vertical_std


def test_a_fix_says_its_moment_in_utc_and_how_late_it_came() -> None:
    late = AutopilotTruth(latency_s=0.35)
    with SimulatedGnss(TRUTH, late) as gnss:
        heard = Listener(f"{gnss.url}?rate=50")
        heard.until(lambda: len(heard.fixes()) > 30)
        heard.port.close()
    fix = heard.fixes()[-1]
    assert fix.device_ns is not None
    assert fix.utc_ns is not None
    assert fix.latency is not None
    assert fix.utc_ns / 1e9 - EPOCH_UTC == pytest.approx(fix.device_ns / 1e9, abs=2e-3)
    assert fix.latency == pytest.approx(0.35, abs=0.05)


def test_a_track_is_seen_in_speed_and_course() -> None:
    going = VehicleTrack(
        np.array([0.0, 1e4]), np.array([[0.0, 0, 0], [6e4, 8e4, 0]])
    )  # 10 m/s, 36.87 deg east of north
    still = AutopilotTruth(velocity_std_m_s=0.0)
    with SimulatedGnss(TRUTH, still, track=going, speed=20.0) as gnss:
        heard = Listener(gnss.url)
        heard.until(lambda: len(heard.fixes()) > 20)
        heard.port.close()
    fix = heard.fixes()[-1]
    assert fix.speed == pytest.approx(10.0, abs=0.01)
    assert fix.course == pytest.approx(np.arctan2(6, 8), abs=1e-3)
    assert fix.velocity_n == pytest.approx((6.0, 8.0), abs=0.02)


def test_a_denied_message_is_reported_and_asked_for_the_old_way() -> None:
    stubborn = AutopilotTruth(denies=frozenset({GLOBAL_POSITION_INT, GPS2_RAW}), default_hz=0.0)
    with SimulatedGnss(TRUTH, stubborn, speed=4.0) as gnss:
        heard = Listener(f"{gnss.url}?rate=50")
        heard.until(lambda: len(heard.fixes("GLOBAL_POSITION_INT")) > 3)
        asked = {one.message: one.outcome for one in heard.port.session.asked}
        heard.port.close()
    assert asked["GPS_RAW_INT"] == "accepted"
    assert asked["GLOBAL_POSITION_INT"] == asked["GPS2_RAW"] == "denied"


def test_another_system_is_counted_and_not_read() -> None:
    with SimulatedGnss(TRUTH, AutopilotTruth(system=7), speed=10.0) as gnss:
        heard = Listener(f"{gnss.url}?system=1")
        heard.until(lambda: heard.decoder.systems[7] > 3)
        heard.port.close()
    assert not heard.records
    assert heard.decoder.system == 1


def test_with_a_key_both_sides_sign_and_only_good_frames_are_read(tmp_path: Path) -> None:
    (tmp_path / "key").write_text(KEY.hex())
    faults = [TimedFault("unsigned", 4.0, 2.0), TimedFault("wrong_key", 6.0, 2.0), TimedFault("replay", 8.0, 2.0)]
    with SimulatedGnss(TRUTH, AutopilotTruth(key=KEY), faults, speed=8.0) as gnss:
        heard = Listener(f"{gnss.url}?key={tmp_path / 'key'}")
        heard.until(lambda: gnss.now > 10.5 and len(heard.fixes()) > 10)
        assert {one.outcome for one in heard.port.session.asked} == {"accepted"}
        heard.port.close()
    counters = heard.decoder.framer.counters
    assert min(counters.unsigned, counters.bad_signature, counters.replayed) > 5
    times = [fix.device_ns / 1e9 for fix in heard.fixes() if fix.device_ns is not None]
    assert not [t for t in times if 4.0 < t < 7.8]
    assert all(np.diff(times) > 0)


def test_without_a_key_an_autopilot_that_wants_signatures_follows_nobody() -> None:
    with SimulatedGnss(TRUTH, AutopilotTruth(key=KEY), speed=20.0) as gnss:
        heard = Listener(gnss.url)
        heard.until(lambda: len(heard.fixes()) > 5)  # what it sends unasked is signed, and can be read
        heard.port.close()
    assert not gnss.autopilot.commands
