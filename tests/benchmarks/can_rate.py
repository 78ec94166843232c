"""Read 3000 CAN frames/s from an slcan adapter on a pty: `python -m tests.benchmarks.can_rate --seconds 300`.

A simulated IMU of 500 Hz, six frames a sample, runs in a process of its own; the reader process reads it through
python-can's slcan, journals it and hands it on; every sample is decoded and counted here. Printed: samples and
frames lost as their counter shows, how many of those were reported, the reader's share of a core, and how long a
frame takes from the adapter to the station (by the age of what a poll returns).
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from drivers.url_wire_format import wire_of
from station.stream.reader import Chunk, Reader
from station.stream.recorder.sample_stream import SampleStream

PERIOD_S, FRAMES = 0.002, 6
TRUTH = f"sample_period_s = {PERIOD_S}\n"


def cpu_s(pid: int) -> float:
    """Return the processor time [s] that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def serve(folder: Path) -> tuple[subprocess.Popen[str], str]:
    """Start a simulated IMU behind an adapter; return its process and its URL."""
    (folder / "truth.toml").write_text(TRUTH)
    options = ("--truth", str(folder / "truth.toml"), "--transport", "slcan", "--pty", str(folder / "can"))
    code = "from station.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code, "simulate", *options], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    return process, process.stdout.readline().removeprefix("url ").strip()


def measure(seconds: float, folder: Path) -> bool:
    """Print what came of ``seconds`` of reading; say whether nothing was lost unreported."""
    device, url = serve(folder)
    try:
        with Reader(url, folder / "journal.mcap") as reader:
            wire = wire_of(reader.address)
            assert wire is not None
            stream, marks, latency = SampleStream(wire), 0, list[float]()
            used, began = cpu_s(reader.pid), time.monotonic()
            while (took := time.monotonic() - began) < seconds:
                for item in reader.poll(0.1):
                    if isinstance(item, Chunk):
                        stream.take(item)
                        latency.append(time.time() - item.host_ns / 1e9)
                    else:
                        marks += 1
            share = (cpu_s(reader.pid) - used) / took
    finally:
        device.terminate()
        device.wait()
    counters, framing = stream.counters, stream.decoder.counters
    print(f"samples {counters.samples} in {took:.1f} s, {counters.samples * FRAMES / took:.0f} frames/s")
    print(f"lost {counters.lost} samples, reported in {counters.breaks} breaks and {marks} gap marks")
    print(f"frames: {framing.incomplete} samples given up, {framing.late} late, {framing.bad_crc} bad check")
    print(f"reader {100 * share:.1f} % of a core; hand-over p50 {1e3 * np.median(latency):.2f} ms,", end=" ")
    print(f"p99 {1e3 * np.percentile(latency, 99):.2f} ms")
    return counters.samples + counters.lost > 0.98 * took / PERIOD_S and (
        counters.lost == 0 or counters.breaks > 0
    )


def main() -> int:
    """Measure; exit 1 where something was lost and not reported."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=300.0)
    with tempfile.TemporaryDirectory() as folder:
        return 0 if measure(parser.parse_args().seconds, Path(folder)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
