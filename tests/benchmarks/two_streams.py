"""An IMU of 2 kHz on a pty, GNSS of 10 Hz, recorded: `python -m tests.benchmarks.two_streams --seconds 600`.

Both devices run in a process of their own. Two reader processes take and journal their bytes; this process decodes
every sample, writes it beside the fixes' time as `station record --gnss` does, and flushes every 0.2 s. Printed:
what was lost by the counter, the IMU reader's share of a core, and how long it takes from the byte (as the reader
stamped it) to the record (the sample was given to the file).
"""

import argparse
import os
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
from tests.benchmarks.can_rate import cpu_s

PERIOD_S, GNSS_HZ = 0.0005, 10
TRUTH = f"sample_period_s = {PERIOD_S}\n"
SETTLE_S = 3.0
ASKED_CORE, ASKED_LATENCY_S = 0.35, 0.020


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


def measure(seconds: float, folder: Path) -> bool:
    """Print what came of ``seconds`` of both streams; say whether it is as asked."""
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
            used, station_used, began = cpu_s(reader.pid), cpu_s(os.getpid()), time.monotonic()
            done = plain_recording.record(timed, folder, seconds, gnss)
            took = time.monotonic() - began
            share = (cpu_s(reader.pid) - used) / took
            own = (cpu_s(os.getpid()) - station_used) / took
            lost, breaks = timed.stream.counters.lost, timed.stream.counters.breaks
            told = gnss.summary
    finally:
        devices.terminate()
        devices.wait()
    p50, p99 = np.percentile(timed.latency, (50, 99))
    print(f"load       {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print(
        f"samples    {done.samples} in {took:.1f} s, {done.samples / took:.0f}/s; {done.path.stat().st_size} bytes"
    )
    print(f"lost       {lost}, breaks {breaks}   asked 0")
    print(f"reader     {100 * share:.1f} % of a core   asked {100 * ASKED_CORE:.0f}; recording {100 * own:.1f} %")
    print(f"latency    p50 {1e3 * p50:.2f} ms, p99 {1e3 * p99:.2f} ms   asked {1e3 * ASKED_LATENCY_S:.0f}")
    print(f"GNSS       {told}")
    return lost == breaks == 0 and share < ASKED_CORE and p99 <= ASKED_LATENCY_S


def main() -> int:
    """Measure; exit 1 where it is not as asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=600.0)
    with tempfile.TemporaryDirectory() as folder:
        return 0 if measure(parser.parse_args().seconds, Path(folder)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
