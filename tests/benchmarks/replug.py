"""Unplug and replug a simulated IMU under a running reader process.

The device is a pty that goes away and comes back as another one under the same link. Counted are gap marks, and
what reaches over a gap: blocks, and the runs that a recording would be cut from.
"""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from drivers.simulated.faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.counts.sample_times import GAP_PERIODS
from station.stream.live.live_feed import open_feed
from station.stream.live.stillness import Block, runs_of_blocks
from station.stream.reader import Chunk, Reader, StreamGap
from station.stream.recorder.sample_buffer import SampleRun
from tests.proof.evidence import Figure, zero

SPEED = 20.0  # device seconds a second: 1000 frames a second
PLUGGED_S = 10.0  # of device time between two unplugs
AWAY_S = (0.05, 2.0)
ASKED_S = 3.0
EVEN_S = 0.01  # of device time: half a sample period


class WatchedReader:
    """A reader whose gap marks and returns are noted on their way."""

    def __init__(self, reader: Reader) -> None:
        self._reader, self.address = reader, reader.address
        self.marks: list[StreamGap] = []
        self.outages: list[float] = []  # from a loss to the first bytes after it [s]

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return what has come."""
        items = self._reader.poll(timeout_s)
        for item in items:
            if isinstance(item, StreamGap):
                self.marks.append(item)
            elif len(self.marks) > 2 * len(self.outages):
                lost = self.marks[2 * len(self.outages)]
                self.outages.append((item.host_ns - lost.host_ns) / 1e9)
        return items


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of it: ``back`` [s] from the port's return to samples, one for each time."""

    back: list[float]
    marks: list[bool]  # whether the port was open then
    blocks: int
    blocks_over_a_gap: int
    runs_over_a_gap: int


def replug(times: int, seed: int, folder: Path, away_s: tuple[float, float] = AWAY_S) -> Outcome:
    """Unplug and replug a device so many times; its link and the recording go into ``folder``."""
    away = np.random.default_rng(seed).uniform(*away_s, times)
    lost = away * SPEED
    at = np.cumsum(np.concatenate([[0.0], lost[:-1]]) + PLUGGED_S)
    faults = [Fault("unplug", at_s=a, seconds=s) for a, s in zip(at, lost, strict=True)]
    device = SimulatedDevice(Truth.example(seed), seed, speed=SPEED, faults=faults, link=folder / "imu")
    blocks, over = list[Block](), 0
    with device, Reader(device.url, folder / "recording.mcap") as reader:
        watched = WatchedReader(reader)
        for block, is_over_a_gap in _blocks(watched):
            blocks.append(block)
            over += is_over_a_gap
            if len(watched.outages) == times and block.is_restarted:
                break
    back = (np.array(watched.outages) - away).tolist()
    runs_over = _over_a_gap(runs_of_blocks(blocks, None), blocks)
    return Outcome(back, [mark.is_open for mark in watched.marks], len(blocks), over, runs_over)


def _blocks(source: WatchedReader) -> Iterator[tuple[Block, bool]]:
    feed = open_feed(source)
    feed.identify()
    for block in feed.blocks():
        samples = feed.buffer.block(block.first, block.last)
        steps = np.diff(samples.device_time) / feed.period
        yield block, bool(np.any(steps > GAP_PERIODS) or np.any(np.diff(samples.counter) != 1))
        feed.buffer.forget_before(block.last)


def _over_a_gap(runs: Sequence[SampleRun], blocks: Sequence[Block]) -> int:
    """Return how many gaps between blocks are inside a run."""
    begins = {first for first, _ in runs}
    return sum(b.begins - a.ends > EVEN_S and b.first not in begins for a, b in pairwise(blocks))


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what came of ``size`` times."""
    with tempfile.TemporaryDirectory() as folder:
        got = replug(size, seed, Path(folder))
    return {
        "samples again after the port, median": Figure(float(np.median(got.back)), "s"),
        "samples again after the port, longest": Figure(max(got.back), "s", at_most=ASKED_S),
        "losses without a gap mark": zero(size - got.marks.count(False)),
        "blocks over a gap": zero(got.blocks_over_a_gap),
        "runs of samples over a gap": zero(got.runs_over_a_gap),
    }
