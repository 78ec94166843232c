"""Freeze the station for 5 s under a device of 1 kHz.

What is frozen (SIGSTOP) is the whole process that decodes, so that it collects nothing; the reader is a process of
its own and goes on. Afterwards every frame must be there by the counter in it, in station and recording.
"""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from drivers.simulated.bench_control import BenchControl
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from station.files.mcap_files import read_step
from station.stream.reader import Chunk, Reader, StreamGap
from station.stream.recorder.sample_stream import SampleStream
from tests.proof.evidence import Figure, zero

FASTEST = Truth(sample_period_s=0.001)
FROZEN_S = 5.0


@dataclass(frozen=True, slots=True)
class Seen:
    """What one end has; ``missing`` counts frames by their counter, breaks in time, restarts and gap marks."""

    samples: int
    missing: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the station saw and what is in the recording; ``blind_s`` is how long the station did not look."""

    station: Seen
    recording: Seen
    blind_s: float


def freeze(recording: Path, speed: float = 1.0) -> Outcome:
    """Freeze a station for 5 s of device time; the device runs at ``speed`` times its rate."""
    with SimulatedDevice(FASTEST, 1, speed=speed) as device, BenchControl(device.control) as hands:
        command = [sys.executable, "-m", "tests.benchmarks.frozen_screen", device.url, str(recording)]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as station:
            assert station.stdout.readline() == "reading\n"
            os.kill(station.pid, signal.SIGSTOP)
            end = hands.time() + FROZEN_S
            while hands.time() < end:
                pass
            os.kill(station.pid, signal.SIGCONT)
            found = json.loads(station.communicate("enough\n")[0])
    return Outcome(Seen(**found["seen"]), seen(Chunk(*raw) for raw in read_step(recording).raw), found["blind_s"])


def seen(items: Iterable[Chunk | StreamGap]) -> Seen:
    """Count what comes."""
    stream, marks = SampleStream(FORMATS["counts"]), 0
    for item in items:
        if isinstance(item, StreamGap):
            marks += 1
        else:
            stream.take(item)
    counted = stream.counters
    return Seen(counted.samples, counted.lost + counted.breaks + counted.restarts + marks)


def be_the_station(url: str, recording: Path) -> None:
    """Read until told that it is enough and everything from before that has come."""
    items, blind_s, enough_ns = list[Chunk | StreamGap](), 0.0, None
    with Reader(url, recording) as reader:
        looked = time.monotonic()
        print("reading", flush=True)  # from here on it may be frozen
        while enough_ns is None or not items or items[-1].host_ns < enough_ns:
            items += reader.poll(1.0)
            blind_s, looked = max(blind_s, time.monotonic() - looked), time.monotonic()
            if enough_ns is None and select.select([sys.stdin], [], [], 0)[0]:
                enough_ns = time.time_ns()
    print(json.dumps({"seen": asdict(seen(items)), "blind_s": blind_s}))


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Freeze it ``size`` times."""
    with tempfile.TemporaryDirectory() as folder:
        got = [freeze(Path(folder) / f"recording_{number}.mcap") for number in range(size)]
    longest = Figure(max(one.blind_s for one in got), "s", at_least=0.9 * FROZEN_S)
    result = {"longest time without a look": longest}
    for name, ends in (("station", [one.station for one in got]), ("recording", [one.recording for one in got])):
        result[f"{name}: frames missing"] = zero(sum(one.missing for one in ends))
        result[f"{name}: frames"] = Figure(sum(one.samples for one in ends))
    return result


if __name__ == "__main__":
    be_the_station(sys.argv[1], Path(sys.argv[2]))
