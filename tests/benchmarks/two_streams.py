"""An IMU of 2 kHz on a pty, GNSS of 10 Hz, recorded for some time.

Both devices run in a process of their own. Two reader processes take and journal their bytes; this process decodes
every sample, writes it beside the fixes' time as `station record --gnss` does, and flushes every 0.2 s.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from drivers.url_wire_format import wire_of
from station.stream.gnss.gnss_feed import open_gnss
from station.stream.live.live_feed import LiveFeed
from station.stream.reader import Reader
from station.stream.recorder import plain_recording
from station.stream.recorder.sample_stream import DecodedChunk, SampleStream
from tests.proof.evidence import Figure, zero

PERIOD_S, GNSS_HZ = 0.0005, 10
TRUTH = f"sample_period_s = {PERIOD_S}\n"
SETTLE_S = 3.0


def serve(folder: Path) -> tuple[subprocess.Popen[str], str, str]:
    """Start a simulated IMU with a receiver beside it; return their process and both URLs."""
    (folder / "truth.toml").write_text(TRUTH)
    options = ("--truth", str(folder / "truth.toml"), "--pty", str(folder / "imu"), "--gnss", "udp")
    code = "from station.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code, "simulate", *options], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    told = dict[str, str]()
    while not {"url", "gnss"} <= told.keys():
        word, _, rest = process.stdout.readline().strip().partition(" ")
        told[word] = rest.strip()
    return process, told["url"], told["gnss"]


class Timed:
    """A feed whose pieces are timed: asked for the next one, the recording has written the one before."""

    def __init__(self, feed: LiveFeed) -> None:
        self._feed = feed
        self.latency: list[float] = []

    @property
    def stream(self) -> SampleStream:
        """What decodes it."""
        return self._feed.stream

    def pieces(self, look: Callable[[], None]) -> Iterator[DecodedChunk]:
        """Yield the feed's pieces, from the next on."""
        self._feed.advance()
        for piece in self._feed.pieces(look):
            yield piece
            self.latency.append(time.time() - piece.chunk.host_ns / 1e9)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Record both for ``size`` seconds."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        devices, url, gnss_url = serve(folder)
        try:
            with (
                Reader(url, folder / "session.mcap") as reader,
                open_gnss(f"{gnss_url}?rate={GNSS_HZ}", folder) as gnss,
            ):
                wire = wire_of(reader.address)
                assert wire is not None
                timed = Timed(feed := LiveFeed(reader, wire))
                caught_up = time.monotonic() + SETTLE_S
                while time.monotonic() < caught_up:  # what came while the receiver's reader started
                    feed.advance()
                    gnss.advance()
                done = plain_recording.record(timed, folder, size, gnss)
                counters = timed.stream.counters
        finally:
            devices.terminate()
            devices.wait()
    p50, p99 = 1e3 * np.percentile(timed.latency, (50, 99))
    return {
        "samples": Figure(done.samples),
        "samples lost": zero(counters.lost),
        "breaks in time": zero(counters.breaks),
        "from the byte to the record, median": Figure(p50, "ms"),
        "from the byte to the record, 99 %": Figure(p99, "ms"),
    }
