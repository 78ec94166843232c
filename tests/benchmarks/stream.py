"""An IMU of 2 kHz on a pty, calibrated and handed on: `python -m tests.benchmarks.stream --seconds 60`.

The device and `station stream` are programs of their own; this process is the client of its datagrams, and with
``--clients N`` threads of a further process are N clients of its Foxglove server. Printed: how long it takes from
the byte (as the reader stamped it, by its journal) to the datagram in this process; in turns with it how long
bytes alone take from a reader to a program that only takes them; what was lost; shares of a core. Where others
work on the machine `chrt -r 10 python -m ...` leaves them out of it.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from drivers.sample_datagram import DATAGRAM
from drivers.simulated.truth import load_truth
from drivers.wire import FORMATS
from procedures.arrays import FloatArray
from station.files.mcap_files import read_step
from station.stream.reader import Chunk, Reader
from station.stream.recorder.sample_stream import SampleStream
from tests.benchmarks.can_rate import cpu_s
from tests.free_port import free_tcp_port
from tests.station.monitor.unit import calibration_of
from tests.station.sending.datagrams import listener
from tests.station.sending.effects import EFFECTS

PERIOD_S = 0.0005
TRUTH = f"sample_period_s = {PERIOD_S}\n"
SETTLE_S = 2.0  # after the first bytes: what had come while programs started
TURNS = 2
ASKED_LATENCY_S = 0.005
PROGRAM = "from station.cli import main; main()"
CLIENT = """
import sys, threading
from tests.station.sending.clients import connected, messages, subscribe
def listen():
    with connected(int(sys.argv[1])) as client:
        subscribe(client)
        for _ in messages(client): pass
for _ in range(int(sys.argv[2])): threading.Thread(target=listen).start()
"""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve the device while the block lasts; give its URL."""
    (folder / "truth.toml").write_text(TRUTH)
    options = ("--truth", str(folder / "truth.toml"), "--pty", str(folder / "imu"))
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", PROGRAM, "simulate", *options],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    try:
        yield process.stdout.readline().strip().partition(" ")[2]
    finally:
        process.terminate()
        process.wait()


def raw(url: str, journal: Path, seconds: float) -> list[float]:
    """Return the ages [s] of pieces of bytes as this process gets them from a reader."""
    ages, begun = list[float](), None
    with Reader(url, journal) as reader:
        while begun is None or time.monotonic() < begun + SETTLE_S + seconds:
            for item in reader.poll(0.1):
                begun = begun or time.monotonic()
                if isinstance(item, Chunk) and time.monotonic() > begun + SETTLE_S:
                    ages.append(time.time() - item.host_ns / 1e9)
    return ages


def streamed(url: str, folder: Path, seconds: float, clients: int) -> tuple[list[float], str, float]:
    """Return the ages [s] of samples as datagrams of them come, what the program said, its share of a core."""
    calibration = folder.parent / "calibration.json"
    document = calibration_of(load_truth(TRUTH)) | {"effects": EFFECTS}
    calibration.write_text(json.dumps(document), encoding="utf-8")
    came = list[tuple[bytes, float]]()
    port, sees = free_tcp_port(), None
    with listener() as bound:
        to = ["--to", f"udp:127.0.0.1:{bound.getsockname()[1]}"]
        to += ["--to", f"foxglove:127.0.0.1:{port}"] if clients else []
        asked = [url, "--calibration", str(calibration), "--folder", str(folder), *to]
        process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM, "stream", *asked], stderr=subprocess.PIPE, text=True
        )
        if clients:
            sees = subprocess.Popen([sys.executable, "-c", CLIENT, str(port), str(clients)])
        came.append((bound.recv(4096), time.time()))
        begun, used = time.monotonic(), cpu_s(process.pid)
        while time.monotonic() < begun + SETTLE_S + seconds:
            came.append((bound.recv(4096), time.time()))
        share = (cpu_s(process.pid) - used) / (SETTLE_S + seconds)
        process.send_signal(signal.SIGINT)
        said = process.communicate()[1]
    if sees is not None:
        sees.kill()
        sees.wait()
    rows = np.frombuffer(b"".join(data for data, _ in came), DATAGRAM)
    stamps = _stamps(next(folder.glob("session_*.mcap")))
    settled = came[0][1] + SETTLE_S
    ages = [at - stamps[t] for t, (_, at) in zip(rows["t_s"].tolist(), came, strict=True) if at > settled]
    missed = int(np.sum(np.diff(rows["sequence"].astype(np.int64)) - 1))
    return ages, f"{said.splitlines()[-2]}; {missed} missed by the client", share


def _stamps(journal: Path) -> dict[float, float]:
    """Return when the bytes of each sample were read [s], by the sample's device time."""
    stream, found = SampleStream(FORMATS["counts"]), dict[float, float]()
    for host_ns, data in read_step(journal).raw:
        found |= dict.fromkeys(stream.take(Chunk(host_ns, data)).block.device_time.tolist(), host_ns / 1e9)
    return found


def _said(name: str, ages: Sequence[float]) -> FloatArray:
    p50, p99, worst = 1e3 * np.percentile(ages, (50, 99, 100))
    print(f"{name:10} p50 {p50:.2f} ms, p99 {p99:.2f} ms, worst {worst:.1f} ms   ({len(ages)})", flush=True)
    return np.array([p50, p99])


def main() -> int:
    """Measure; exit 1 where it is not as asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--clients", type=int, default=0)
    options = parser.parse_args()
    each, ages, bytes_alone = options.seconds / TURNS, list[float](), list[float]()
    with tempfile.TemporaryDirectory() as temporary, served(Path(temporary)) as url:
        for turn in range(TURNS):
            found = raw(url, Path(temporary) / f"{turn}.mcap", each)
            _said("raw", found)
            bytes_alone += found
            found, said, share = streamed(url, Path(temporary) / f"s{turn}", each, options.clients)
            _said("stream", found)
            print(f"           {100 * share:.0f} % of a core; {said}", flush=True)
            ages += found
    print(f"load       {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    _said("raw", bytes_alone)
    _, p99 = _said("stream", ages)
    print(f"asked      p99 {1e3 * ASKED_LATENCY_S:.0f} ms")
    return 0 if p99 <= 1e3 * ASKED_LATENCY_S else 1


if __name__ == "__main__":
    raise SystemExit(main())
