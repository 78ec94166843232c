"""A receiver read by its own process: fixes, time, site, files; what is wrong, and a reader that dies."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from drivers.address_parsing import parse_device_url
from drivers.errors import BadDeviceUrl
from drivers.simulated.companions.gnss_server import Autopilot, SimulatedGnss
from drivers.simulated.companions.truths import EPOCH_UTC, AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from procedures.gnss_records import GnssFix
from station.files.mcap_files.gnss_file import FIX_MESSAGES, FixWriter
from station.stream.gnss_feed import GnssFeed, open_gnss
from station.stream.reader import Chunk, StreamGap
from station.stream.reader.reader import RestartingReader
from tests.patience import HANG_S, longer
from tests.refusals import refused

TRUTH = Truth(latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)


def wait(feed: GnssFeed, done: Callable[[], bool]) -> None:
    """Advance until something is true."""
    began = time.monotonic()
    while not done():
        assert time.monotonic() - began < HANG_S, (feed.trouble, feed.decoder.framer.counters, feed.latest)
        feed.advance(0.05)


def test_site_time_rate_and_files_come_from_one_receiver(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, speed=10.0) as gnss, open_gnss(f"{gnss.url}?rate=5", tmp_path) as feed:
        wait(feed, lambda: len(feed.fixes) > 150)
        host = time.time_ns()
        utc, site, true = feed.utc(host), feed.site(), gnss.now + EPOCH_UTC
        assert feed.trouble == ""
        received = [record for record in feed.take(host) if isinstance(record, GnssFix)]
        assert not feed.take(host)
        assert all(not fix.is_filtered for fix in feed.fixes)
    assert site is not None
    assert utc is not None
    assert utc == pytest.approx(true, abs=longer(0.05) * 10)  # 50 ms of the host
    assert abs(site.latitude - np.radians(48.1)) * 6.37e6 < 4 * site.horizontal_std
    (recording,) = tmp_path.glob("gnss_session_*.mcap")
    (fixes,) = set(tmp_path.glob("gnss_*.mcap")) - {recording}
    with recording.open("rb") as stream:
        assert {channel.topic for _, channel, _ in make_reader(stream).iter_messages()} == {"/gnss/raw"}
    with fixes.open("rb") as stream:
        written = [
            FIX_MESSAGES[GnssFix].FromString(message.data)
            for _, _, message in make_reader(stream).iter_messages(topics=["/gnss/fix"])
        ]
    assert len(written) == len(received) > len(feed.fixes)
    assert not any(one.HasField("heading") for one in written)  # not known: absent, not 0


class InMemory:
    """An autopilot heard without a port, in its own time: each poll is a tenth of a second."""

    def __init__(self, fault: TimedFault, key_file: Path | None = None) -> None:
        query = f"?key={key_file}" if key_file else ""
        self.address = parse_device_url(f"mavlink:udpin:127.0.0.1:14550{query}")
        self.now = 0.0
        key = key_file.read_bytes() if key_file else b""
        self._autopilot = Autopilot(TRUTH, AutopilotTruth(default_hz=10.0, key=key), [fault])

    def clock(self) -> float:
        return self.now

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        self.now += 0.1
        data = self._autopilot.due(self.now)
        return [Chunk(round(self.now * 1e9), data)] if data else []


@pytest.mark.parametrize(
    ("fault", "reported"),
    [
        (TimedFault("outage", 5.0, 5.0), "no bytes for 1.8 s"),
        (TimedFault("no_fix", 5.0, 5.0), "no fix (3 satellites)"),
        (TimedFault("wrong_system", 5.0, 5.0, 9), "system 1, 9 is there"),
        (TimedFault("bad_crc", 5.0, 5.0), "no MAVLink frame"),
        (TimedFault("noise", 5.0, 5.0), "no MAVLink frame"),
        (TimedFault("half", 5.0, 5.0), "no MAVLink frame"),
        (TimedFault("backlog", 5.0, 5.0), "no bytes for 1.8 s"),
        (TimedFault("unsigned", 5.0, 5.0), "frames signed with the key given"),
        (TimedFault("wrong_key", 5.0, 5.0), "frames signed with the key given"),
        (TimedFault("replay", 5.0, 5.0), ""),
        (TimedFault("repeated", 5.0, 5.0), ""),
        (TimedFault("deaf", 5.0, 5.0), ""),
        (TimedFault("time_jump", 5.0, 5.0, 30.0), ""),
    ],
    ids=lambda each: each.kind if isinstance(each, TimedFault) else "",
)
def test_what_is_wrong_is_reported_within_two_seconds_and_then_that_it_is_over(
    fault: TimedFault, reported: str, tmp_path: Path
) -> None:
    (tmp_path / "key").write_bytes(bytes(range(1, 33)))
    is_signed = fault.kind in {"unsigned", "wrong_key", "replay"}
    source = InMemory(fault, tmp_path / "key" if is_signed else None)
    feed, heard = GnssFeed(source, clock=source.clock), dict[str, float]()
    while source.now < 15.0:
        feed.advance()
        heard.setdefault(feed.trouble, source.now)
        state = feed.stream()
        assert (state.trouble, state.samples, state.gaps) == (feed.trouble, len(feed.fixes), 0)
        if 1.0 < source.now < 5.0 or source.now > 11.2:
            assert feed.trouble == ""
    if not reported:
        assert set(heard) == {""}
        return
    at = min(at for text, at in heard.items() if reported in text)  # a count in it goes on
    assert 5.0 < at <= 7.0
    assert state.name == f"GNSS {feed.address.name}"
    assert state.rate_hz > 8.0  # what came late came all at once
    assert state.age_s <= 0.1 + 1e-9
    assert state.bad == feed.decoder.framer.counters.bad_crc


@pytest.mark.parametrize("kind", ["repeated", "backlog", "half"])
def test_no_fault_of_the_line_makes_a_fix_that_was_not_sent(kind: str) -> None:
    source, clean = InMemory(TimedFault(kind, 5.0, 5.0)), InMemory(TimedFault(kind, 500.0, 5.0))
    feed, true = GnssFeed(source, clock=source.clock), GnssFeed(clean, clock=clean.clock)
    while source.now < 15.0:
        feed.advance()
        true.advance()
    sent = {(fix.utc_ns, fix.latitude, fix.longitude) for fix in true.fixes}
    got = [(fix.utc_ns, fix.latitude, fix.longitude) for fix in feed.fixes]
    assert set(got) <= sent
    assert len(set(got)) >= (0.6 if kind == "half" else 0.97) * len(sent)
    assert feed.trouble == ""


def test_a_port_that_went_comes_back_by_itself(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, transport="tcp") as gnss, open_gnss(f"{gnss.url}?rate=10", tmp_path) as feed:
        wait(feed, lambda: bool(feed.fixes))
        gnss.plant("unplug", 1.0)
        wait(feed, lambda: "lost" in feed.trouble)
        before = len(feed.fixes)
        wait(feed, lambda: feed.trouble == "" and len(feed.fixes) > before + 3)


def test_a_jump_of_the_senders_time_does_not_bend_the_line(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, speed=10.0) as gnss, open_gnss(gnss.url, tmp_path) as feed:
        wait(feed, lambda: len(feed.fixes) > 20)
        gnss.plant("time_jump", 2.0, 30.0)
        over = gnss.now + longer(12.0)
        wait(feed, lambda: gnss.now > over)
        line = feed._utc.around(time.time_ns())  # noqa: SLF001
        assert line is not None
        assert line.rate == pytest.approx(10.0, rel=0.02)
        assert line.at(time.time_ns()) == pytest.approx(gnss.now + EPOCH_UTC, abs=1.0)


def test_an_address_that_is_no_receiver_is_refused(tmp_path: Path) -> None:
    with refused(BadDeviceUrl, ErrorCode.DEVICE_ADDRESS, "mavlink:LINK:WHERE"):
        with open_gnss("tcp://127.0.0.1:1", tmp_path):
            pass


def test_the_receivers_reader_dies_and_another_takes_its_place(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, speed=2.0) as gnss, _feed(f"{gnss.url}?rate=10", tmp_path) as (feed, source):
        _wait(feed, lambda: len(feed.fixes) > 5)
        dead, before = source.reader.pid, feed.fixes[-1]
        os.kill(dead, signal.SIGKILL)
        _wait(feed, lambda: bool(feed.trouble))
        assert "the reader process ended, exit code -9; it is tried again and again" in feed.trouble
        _wait(feed, lambda: not feed.trouble and feed.fixes[-1].host_ns > before.host_ns)
        assert source.reader.pid != dead
        assert before.host_ns < feed.up_to_ns <= time.time_ns()
        assert before in feed.fixes
    sessions = sorted(tmp_path.glob("gnss_session_*.mcap"))
    assert len(sessions) == 2
    (fixes,) = set(tmp_path.glob("gnss_*.mcap")) - set(sessions)
    with fixes.open("rb") as stream:
        marks = [record.metadata for record in make_reader(stream).iter_metadata() if record.name == "station.gap"]
    assert [mark["is_open"] for mark in marks] == ["false", "true"]
    assert "the reader process ended" in marks[0]["reason"]


def test_a_reader_that_cannot_begin_again_is_tried_until_it_can(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, transport="tcp") as gnss, _feed(gnss.url, tmp_path) as (feed, source):
        _wait(feed, lambda: bool(feed.fixes))
        gnss.plant("unplug", 2.0)
        _wait(feed, lambda: "port lost" in feed.trouble)
        os.kill(source.reader.pid, signal.SIGKILL)
        _wait(feed, lambda: "the reader process ended" in feed.trouble)
        count = len(feed.fixes)
        _wait(feed, lambda: not feed.trouble and len(feed.fixes) > count)


@contextmanager
def _feed(url: str, folder: Path) -> Iterator[tuple[GnssFeed, RestartingReader]]:
    with RestartingReader(url, folder) as source:
        writer = FixWriter(folder / "gnss_x.mcap")
        try:
            yield GnssFeed(source, writer), source
        finally:
            writer.close()


def _wait(feed: GnssFeed, done: Callable[[], bool]) -> None:
    deadline = time.monotonic() + HANG_S
    while not done():
        assert time.monotonic() < deadline, feed.trouble
        feed.advance(0.02)
