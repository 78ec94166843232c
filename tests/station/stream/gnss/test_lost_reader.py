"""A receiver's reader process that dies: said, marked in the files, and another takes its place."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from mcap.reader import make_reader

from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.truth import Truth
from station.files.mcap_files.fix_writer import FixWriter
from station.stream.gnss.gnss_feed import GnssFeed
from station.stream.reader.restarting_reader import RestartingReader
from tests.patience import HANG_S

TRUTH = Truth(latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)


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
