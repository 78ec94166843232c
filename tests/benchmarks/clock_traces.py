"""Record how late a device and a receiver beside it are read on this machine under load.

`python -m tests.benchmarks.clock_traces record FILE` takes half an hour; `tests/data/clock_traces.npz` holds
what came of it once. A simulated device on a real pty and a simulated receiver on UDP, in a process of their
own, are read by the station's reader processes while as many processes burn the processor as a run's ``load``
says, beside whatever else the machine has to do. True time is that of the device's own schedule, which its
process tells.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from drivers.simulated import server
from drivers.simulated.autopilot_truth import EPOCH_UTC
from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.server import Pace
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.earth.gnss_records import TimeMark
from station.stream.gnss.gnss_feed import GnssFeed, open_gnss
from station.stream.live.live_feed import open_feed
from station.stream.reader import Reader
from station.stream.recorder.row_times import RowTimes
from tests.paths import ROOT

STORE = ROOT / "tests" / "data" / "clock_traces.npz"
# load, length [s], whether the reader is killed halfway and another one begins
RUNS = (
    *[(0, 180.0, False)] * 3, (0, 180.0, True), *[(1, 120.0, False)] * 4,
    *[(2, 120.0, False)] * 3, (2, 120.0, True),
    *[(4, 60.0, False)] * 3, *[(8, 60.0, False)] * 2, *[(15, 45.0, False)] * 2, (15, 45.0, True),
)  # fmt: skip
PAUSE_S = 3.0  # between a kill and the next reader
SETTLING_S = 4.0  # after the load began
UNITS = {"row_s": 1e4, "mark_s": 1e4, "step_s": 1e4, "row": 1e5, "mark": 1e5, "step": 1e5}  # kept as integers

Stamps = tuple[list[tuple[float, int]], list[tuple[int, int]]]


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """One recording. True times [s] and by how much later each was stamped [s]: of rows (n,) and of marks (m,).

    ``step_s`` and ``step`` (k,) are when the simulated device, having fallen behind, began its schedule anew, and
    by how much later than before [s]. ``runnable`` is the mean number of processes that wanted a processor.
    """

    load: int
    is_killed: bool
    runnable: float
    row_s: FloatArray
    row: FloatArray
    mark_s: FloatArray
    mark: FloatArray
    step_s: FloatArray
    step: FloatArray


def read_traces(path: Path = STORE) -> list[Trace]:
    """Return the traces that a file holds."""
    with np.load(path) as held:
        count = len({name.split("_")[0] for name in held.files})
        return [
            _read_trace({field.name: held[f"{i}_{field.name}"] for field in fields(Trace)}) for i in range(count)
        ]


def _read_trace(held: dict[str, np.ndarray]) -> Trace:  # type: ignore[type-arg]
    whole = {name: held[name] / unit for name, unit in UNITS.items()}
    return Trace(int(held["load"]), bool(held["is_killed"]), float(held["runnable"]), **whole)


def write_traces(path: Path, traces: list[Trace]) -> None:
    """Write traces, times in 0.1 ms and delays in 10 us."""
    arrays = {
        f"{i}_{f.name}": np.asarray(getattr(trace, f.name))
        for i, trace in enumerate(traces)
        for f in fields(Trace)
    }
    for name, value in arrays.items():
        if (unit := UNITS.get(name.split("_", 1)[1])) is not None:
            arrays[name] = np.round(value * unit).astype(np.int32)
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]


class Told(Pace):
    """A pace that tells where its schedule begins, and begins anew."""

    def __init__(self, speed: float, period: float) -> None:
        super().__init__(speed, period)
        self._told = -1
        self._tell()

    def delay(self, sample: int) -> float:
        """Return how long [s] to wait until ``sample`` is due."""
        early = super().delay(sample)
        self._tell()
        return early

    def _tell(self) -> None:
        if self._anchored != self._told:
            self._told = self._anchored
            say(f"anchor {self._anchor!r} {self._anchored}")


def say(line: str) -> None:
    """Write a line at once, as it would come apart where two threads print."""
    os.write(1, line.encode() + b"\n")


def serve() -> None:
    """Be the device and the receiver until stdin is closed."""
    server.Pace = Told  # type: ignore[misc]
    truth = Truth.example(5)
    with server.SimulatedDevice(truth, 5) as device, SimulatedGnss(truth, beside=device) as gnss:
        say(f"urls {device.url} {gnss.url} {truth.sample_period_s}")
        sys.stdin.read()


@contextmanager
def burning(load: int) -> Iterator[None]:
    """Burn the processor by so many processes."""
    with ExitStack() as stack:
        for _ in range(load):
            process = subprocess.Popen([sys.executable, "-S", "-c", "while True: pass"])
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield


def record(load: int, seconds: float, *, is_killed: bool) -> Trace:
    """Record one trace."""
    command = [sys.executable, "-m", "tests.benchmarks.clock_traces", "serve"]
    told, parts, runnable = list[str](), list[Stamps](), list[int]()
    with (
        tempfile.TemporaryDirectory() as name,
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process,
    ):
        assert process.stdin is not None
        assert process.stdout is not None
        while not any(line.startswith("urls") for line in told):
            told.append(process.stdout.readline())
            assert told[-1], "the device did not begin"
        _, device, gnss, period = next(line for line in told if line.startswith("urls")).split()
        since = time.time_ns() - time.monotonic_ns()
        lengths = [seconds / 2, seconds / 2] if is_killed else [seconds]
        with burning(load):
            time.sleep(SETTLING_S)
            for i, length in enumerate(lengths):
                (folder := Path(name) / str(i)).mkdir()
                is_last = i + 1 == len(lengths)
                parts.append(_read(device, gnss, folder, length, runnable, is_killed=not is_last))
                time.sleep(0.0 if is_last else PAUSE_S)
        process.stdin.close()
        told += process.stdout.readlines()
    anchors = np.array([line.split()[1:] for line in told if line.startswith("anchor")], dtype=float)
    row_s, row_ns = (np.array(each) for each in zip(*(row for rows, _ in parts for row in rows), strict=True))
    utc_ns, mark_ns = (
        np.array(each) for each in zip(*(mark for _, marks in parts for mark in marks), strict=True)
    )
    mark_s = (utc_ns - round(EPOCH_UTC * 1e9)) / 1e9
    begin, first = anchors[:, 0], anchors[:, 1] * float(period)

    def late(true_s: FloatArray, host_ns: FloatArray) -> FloatArray:
        i = np.maximum(np.searchsorted(first, true_s) - 1, 0)
        return np.asarray((host_ns - since) / 1e9 - (begin[i] + true_s - first[i]))

    return Trace(
        load, is_killed, float(np.mean(runnable)), row_s, late(row_s, row_ns), mark_s, late(mark_s, mark_ns),
        first[1:], np.diff(begin) - np.diff(first),
    )  # fmt: skip


def _read(device: str, gnss: str, folder: Path, seconds: float, runnable: list[int], *, is_killed: bool) -> Stamps:
    """Return rows (device time [s], host [ns]) and marks (UTC [ns], host [ns])."""
    rows, marks, times = list[tuple[float, int]](), list[tuple[int, int]](), RowTimes(lambda ns: ns / 1e9)
    with Reader(device, folder / "journal.mcap") as reader, open_gnss(gnss, folder) as receiver:
        feed = open_feed(reader)
        until, look = time.monotonic() + seconds, 0.0
        while time.monotonic() < until:
            feed.advance()
            marks += _marks(receiver)
            if feed.stamp is not None and times.of(feed.stamp[0]) is not None:
                rows.append((feed.stamp[1], feed.stamp[0]))
            if time.monotonic() >= look:
                look = time.monotonic() + 0.5
                runnable.append(int(Path("/proc/loadavg").read_text().split()[3].split("/")[0]) - 1)
        if is_killed:
            os.kill(reader.pid, 9)
    return rows, marks


def _marks(receiver: GnssFeed) -> list[tuple[int, int]]:
    receiver.advance()
    come = (one for one in receiver.take(2**62) if isinstance(one, TimeMark))
    return [(one.utc_ns, one.host_ns) for one in come if one.utc_ns is not None]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("record", "serve"))
    parser.add_argument("file", type=Path, nargs="?", default=STORE)
    parser.add_argument("--runs", type=int, nargs="*", help="of the table `RUNS`; all by default")
    given = parser.parse_args()
    if given.what == "serve":
        serve()
        return
    traces = list[Trace]()
    print("run load runnable | rows and marks late [ms]: least, median, 99 %, most | schedules begun anew")
    for i in given.runs or range(len(RUNS)):
        load, seconds, is_killed = RUNS[i]
        traces.append(trace := record(load, seconds, is_killed=is_killed))
        late = [
            f"{1e3 * np.quantile(each, at):.1f}" for each in (trace.row, trace.mark) for at in (0, 0.5, 0.99, 1)
        ]
        print(i, load, f"{trace.runnable:.1f}", "|", *late, "|", len(trace.step), flush=True)
        write_traces(given.file, traces)


if __name__ == "__main__":
    main()
