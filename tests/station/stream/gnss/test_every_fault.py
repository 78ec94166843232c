"""Every fault of a GNSS link and its sender through the real reader process: told, and over within 3 s.

Sender and station's clock run `SPEED` times as fast, less on a busy machine. Told means that no look at the feed
later than `TOLD_S` after the last good fix finds nothing said: 2 s, and what a busy machine may add between fix
and bytes. test_gnss_feed.py has the 2 s alone, in device time.
"""

import os
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest
from mcap.reader import make_reader

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.truth import Truth
from procedures.earth.gnss_records import FixType, GnssFix
from station.files.mcap_files.fix_writer import FixWriter
from station.stream.gnss.gnss_feed import GnssFeed
from station.stream.reader.restarting_reader import FOR_EVER, RestartingReader
from tests.patience import HANG_S, paced

TRUTH = Truth(latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
SPEED, POLL_S = 2.0, 0.01
LASTS_S = 3.5
TOLD_S, BACK_S = 2.5, 3.0
FRESH_S = 1.5  # fixes come: nothing may be amiss but what is asked for
TRANSPORTS = ("udp", "tcp", "pty")
HZ = 10.0


@dataclass(frozen=True)
class Case:
    """A fault and what the operator must read; empty: nothing, because nothing is wrong."""

    kind: str
    says: str
    size: float = 0.0


CASES = (
    Case("outage", "no bytes for 1.8 s"),
    Case("noise", "no MAVLink frame"),
    Case("repeated", ""),
    Case("half", "no MAVLink frame"),
    Case("bad_crc", "no MAVLink frame"),
    Case("no_fix", "no fix (3 satellites)"),
    Case("deaf", ""),
    Case("wrong_system", "9 is there, expected", 9),
    Case("time_jump", "", 30.0),
    Case("backlog", "no bytes for 1.8 s"),
)
SLOTS = 6  # at once: a case takes seconds
SHARES = {f"{TRANSPORTS[k % len(TRANSPORTS)]}{k}": CASES[k::SLOTS] for k in range(SLOTS)}
SIGNED = (
    Case("unsigned", "frames signed with the key given"),
    Case("wrong_key", "frames signed with the key given"),
    Case("replay", ""),
)
SIGNED_SHARES = {"signed": SIGNED[:2], "replayed": SIGNED[2:]}


class Look(NamedTuple):
    """A look at the feed: when by the sender's clock [s], how long since the last fix [s], what was said."""

    at: float
    since_fix: float
    trouble: str


class Run:
    """What a station saw of a sender with one fault after another, by case."""

    def __init__(
        self, cases: tuple[Case, ...], transport: str, speed: float, folder: Path, key: bytes = b""
    ) -> None:
        folder.mkdir()
        self.looks: dict[Case, list[Look]] = {}
        self.over: dict[Case, float] = {}  # when by the sender's clock
        self._speed = speed
        options = f"?rate={HZ:g}"
        if key:
            (folder / "key").write_bytes(key)
            options += f"&key={folder / 'key'}"
        autopilot = AutopilotTruth(default_hz=HZ, key=key)
        with SimulatedGnss(TRUTH, autopilot, transport=transport, speed=self._speed) as gnss:
            with RestartingReader(gnss.url + options, folder) as source:
                self._feed, self._fix_at = GnssFeed(source, clock=self.clock), self.clock()
                for case in cases:
                    self._look(gnss, lambda look: look.since_fix < FRESH_S and not look.trouble)
                    begins = gnss.now
                    gnss.plant(case.kind, LASTS_S, case.size)
                    self.over[case] = over = begins + LASTS_S
                    self.looks[case] = self._look(gnss, lambda look, until=over + BACK_S: look.at > until)
        assert gnss.failure is None

    def clock(self) -> float:
        return time.monotonic() * self._speed

    def _look(self, gnss: SimulatedGnss, done: Callable[[Look], bool]) -> list[Look]:
        looks, deadline = list[Look](), time.monotonic() + HANG_S
        while not looks or not done(looks[-1]):
            assert time.monotonic() < deadline, looks[-1]
            self._feed.advance(POLL_S)
            told = [record for record in self._feed.take(FOR_EVER) if isinstance(record, GnssFix)]
            if any(fix.fix >= FixType.FIX_2D for fix in told if not fix.is_filtered):
                self._fix_at = self.clock()
            looks.append(Look(gnss.now, self.clock() - self._fix_at, self._feed.trouble))
        return looks


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Run]:
    folder, key = tmp_path_factory.mktemp("gnss"), bytes(range(1, 33))
    speed = paced(SPEED)  # once: what begins here is no load of the machine's
    with ThreadPoolExecutor(len(SHARES) + len(SIGNED_SHARES)) as pool:
        found = {each: pool.submit(Run, cases, each[:3], speed, folder / each) for each, cases in SHARES.items()}
        found |= {
            each: pool.submit(Run, cases, "udp", speed, folder / each, key)
            for each, cases in SIGNED_SHARES.items()
        }
        return {name: run.result() for name, run in found.items()}


ROWS = [(each, case) for each, cases in (SHARES | SIGNED_SHARES).items() for case in cases]


@pytest.mark.parametrize(("run", "case"), ROWS, ids=[f"{run}-{case.kind}" for run, case in ROWS])
def test_every_fault_of_a_receiver_is_told_and_over(run: str, case: Case, runs: dict[str, Run]) -> None:
    looks = runs[run].looks[case]
    if not case.says:
        assert {look.trouble for look in looks if look.since_fix < FRESH_S} == {""}
        return
    late = [look for look in looks if look.since_fix > TOLD_S and look.at < runs[run].over[case]]
    assert late
    assert all(look.trouble for look in late), late
    assert any(case.says in look.trouble for look in looks)
    assert looks[-1].trouble == ""


def test_the_receivers_reader_dies_and_another_takes_its_place(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, speed=SPEED) as gnss, _feed(f"{gnss.url}?rate=10", tmp_path) as (feed, source):
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
