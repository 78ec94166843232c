"""How late a device and a receiver next to it were read on a loaded machine, recorded once.

A simulated device on a real pty and a simulated receiver on UDP, in a process of their own, were read by the
station's reader processes while as many processes burned the processor as a trace's ``load`` says. True time is
that of the device's own schedule.

Campaigns are put together from stretches of these delays, rows and marks of one moment together, and go through
what the station does with them: marks to UTC of rows at the end of each step. The station's own clock is up to 50
ppm off.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray, IntArray
from station.stream.gnss_fix_times import UtcLine
from tests.paths import ROOT

LAYOUTS = ((10.0, 8.0), (30.0, 10.0), (90.0, 30.0))  # of twelve dwells and the pauses between them [s]
STRETCH_S = 20.0, 60.0
HOST_PPM = 50.0
BEGIN_S = 30.0
LATER_NS = 10**9  # than its last row a step is written
STORE = ROOT / "tests" / "data" / "clock_traces.npz"
UNITS = {"row_s": 1e4, "mark_s": 1e4, "step_s": 1e4, "row": 1e5, "mark": 1e5, "step": 1e5}  # kept as integers


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


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """True times (n,) [s] of rows and marks, and when the station stamped them [ns]."""

    row_s: FloatArray
    row_ns: IntArray
    mark_s: FloatArray
    mark_ns: IntArray


def timeline(traces: Sequence[Trace], seconds: float, rng: np.random.Generator) -> Timeline:
    """Put stretches of traces end to end; where the simulated device began its schedule anew, time is lost."""
    at, lost = 0.0, 0.0
    parts = list[tuple[FloatArray, ...]]()
    host = 1.0 + rng.uniform(-HOST_PPM, HOST_PPM) * 1e-6
    while at < seconds:
        trace = traces[int(rng.integers(len(traces)))]
        first, last = float(trace.row_s[0]), float(trace.row_s[-1])
        length = min(float(rng.uniform(*STRETCH_S)), last - first)
        begin = float(rng.uniform(first, max(last - length, first)))
        stretch = list[FloatArray]()
        steps = (trace.step_s >= begin) & (trace.step_s < begin + length)
        for true, late in ((trace.row_s, trace.row), (trace.mark_s, trace.mark)):
            keep = (true >= begin) & (true < begin + length)
            fallen = lost + np.array([trace.step[steps & (trace.step_s < t)].sum() for t in true[keep]])
            stretch += [true[keep] - begin + at, (true[keep] - begin + at + fallen + late[keep]) * host]
        parts.append(tuple(stretch))
        lost += float(trace.step[steps].sum())
        at += length
    row, row_host, mark, mark_host = (np.concatenate(each) for each in zip(*parts, strict=True))
    return Timeline(row, _stamped(row_host), mark, _stamped(mark_host))


def _stamped(host: FloatArray) -> IntArray:
    return np.maximum.accumulate(np.round(host * 1e9).astype(np.int64))


def campaign(
    traces: Sequence[Trace], dwell_s: float, pause_s: float, ppm: float, rng: np.random.Generator
) -> list[tuple[FloatArray, FloatArray]]:
    """Return device time and UTC [s] of the rows of twelve dwells, of a device whose clock is ``ppm`` fast."""
    line = timeline(traces, BEGIN_S + 12 * (dwell_s + pause_s) + STRETCH_S[1], rng)
    utc, numbered = UtcLine(), 0
    dwells = list[tuple[FloatArray, FloatArray]]()
    for i in range(12):
        begin = BEGIN_S + pause_s + i * (dwell_s + pause_s)
        rows = np.flatnonzero((line.row_s >= begin) & (line.row_s < begin + dwell_s))
        if not len(rows):  # a reader that was killed, and the next one still starting
            continue
        until = int(np.searchsorted(line.mark_ns, line.row_ns[rows[-1]] + LATER_NS))
        for mark in range(numbered, until):
            utc.mark(int(line.mark_ns[mark]), round(line.mark_s[mark] * 1e9))
        numbered = max(numbered, until)
        read = [utc.utc(int(host)) for host in line.row_ns[rows]]
        times = np.array([np.nan if one is None else one for one in read])
        dwells.append((line.row_s[rows] * (1 + 1e-6 * ppm), times))
    return dwells
