"""How honest `clock.rate` is beside a receiver on a busy machine.

Campaigns are put together from stretches of recorded delays (`tests.benchmarks.clock_traces`), rows and marks of
one moment together, and go through what the station does with them: marks to UTC of rows at the end of each
step, rows to a rate. The station's own clock is up to 50 ppm off besides. A rate is false that is 4 sigma from
the truth.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.counts.reference_time import fit_clock
from station.stream.gnss.utc_line import UtcLine
from tests.benchmarks.clock_traces import Trace, read_traces
from tests.proof.evidence import Figure

LAYOUTS = ((10.0, 8.0), (30.0, 10.0), (90.0, 30.0))  # of twelve dwells and the pauses between them [s]
STRETCH_S = 20.0, 60.0
HOST_PPM = 50.0
BEGIN_S = 30.0
SIGMAS = 4.0  # beyond which a rate is called false, or found
LATER_NS = 10**9  # than its last row a step is written
LOADS = ((0,), (1,), (2,), (4, 8), (15,))


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
    utc, told = UtcLine(), 0
    dwells = list[tuple[FloatArray, FloatArray]]()
    for i in range(12):
        begin = BEGIN_S + pause_s + i * (dwell_s + pause_s)
        rows = np.flatnonzero((line.row_s >= begin) & (line.row_s < begin + dwell_s))
        if not len(rows):  # a reader that was killed, and the next one still starting
            continue
        until = int(np.searchsorted(line.mark_ns, line.row_ns[rows[-1]] + LATER_NS))
        for mark in range(told, until):
            utc.mark(int(line.mark_ns[mark]), round(line.mark_s[mark] * 1e9))
        told = max(told, until)
        read = [utc.utc(int(host)) for host in line.row_ns[rows]]
        times = np.array([np.nan if one is None else one for one in read])
        dwells.append((line.row_s[rows] * (1 + 1e-6 * ppm), times))
    return dwells


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return, for each load of the machine, how honest and how good the rates of ``size`` campaigns are."""
    result, traces = dict[str, Figure](), read_traces()
    for loads in LOADS:
        some = [trace for trace in traces if trace.load in loads]
        z, errors = list[float](), list[float]()
        for i in range(size):
            ppm = (0.0, 50.0, 0.0, -50.0)[i % 4]
            rng = np.random.default_rng([seed, i])
            if (rate := fit_clock(campaign(some, *LAYOUTS[i % len(LAYOUTS)], ppm, rng))) is not None:
                errors.append(rate.ppm - ppm)
                z.append(errors[-1] / rate.std)
        title = f"load {'-'.join(map(str, loads))}"
        result[f"{title}: error, rms"] = Figure(np.sqrt(np.mean(np.square(errors))), "ppm")
        result[f"{title}: error over u, rms"] = Figure(np.sqrt(np.mean(np.square(z))), at_most=1.5)
        result[f"{title}: beyond {SIGMAS:g} u"] = Figure(sum(abs(each) > SIGMAS for each in z), of=len(z))
    return result
