"""A simulated device with one fault after another, read by the real reader process, held against its truth.

Device and station's clock run `SPEED` times as fast, less on a busy machine. Times are of the device; what is
missing while a port is away or an adapter is deaf is real time, see test_can_faults.py. On udp_multicast, where
nothing else holds a sender up, the device goes on when what it sent has been read: a kernel has room for 85 ms.
"""

import re
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from drivers.errors import DriverError
from drivers.ports import wire_of
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.faults import Fault, Sent
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import WireFormat
from procedures.arrays import IntArray
from procedures.counts.sample_records import SampleBlock
from station.stream.live.live_feed import LiveFeed
from station.stream.live.stillness import Block
from station.stream.reader import Chunk, Reader
from tests.free_port import free_udp_port
from tests.patience import HANG_S
from tests.udp_queues import waiting_for_others

SPEED, PERIOD, SEED = 10.0, 0.02, 5
TRUTH = Truth(sample_period_s=PERIOD, accel_noise_g=0.3, gyro_arw_deg_rt_s=0.01)  # no sample like another
BEGIN_S, SLOT_S, LASTS_S, BACKLOG_S = 4.0, 8.0, 4.0, 5.0
BACK_S = 3.0
LOOK_S = 0.01
TRANSPORTS = ("pty", "tcp", "slcan", "udp_multicast")


@dataclass(frozen=True)
class Case:
    """A fault, how long it lasts [s], by transport what the operator must read, and how many samples are gone.

    ``*`` is for all others. An empty ``says``: nothing is said, because nothing is wrong. -1 of ``gone``: what the
    kernel has no room for, marked; without any: what another device's frames spoil.
    """

    name: str
    fault: Fault
    says: dict[str, str]
    lasts_s: float = LASTS_S
    gone: dict[str, int] = field(default_factory=dict)

    def reported_on(self, transport: str) -> str:
        return self.says.get(transport, self.says.get("*", ""))


SILENT = "no bytes for 1.8 s"
DEAF = "the adapter no longer answers"
NOISE = {"*": "frame; ", "udp_multicast": SILENT}  # which has no place for it
GONE = {"*": "was lost", "udp_multicast": SILENT}
KERNEL = {"*": 0, "udp_multicast": -1}  # what it has no room for is lost, and marked
NO_CLOCK = {"*": "jumps of the device's clock", "slcan": "", "udp_multicast": ""}  # in the frames
LASTING = round(LASTS_S / PERIOD)
CASES = (
    Case("counter wrap", Fault("counter_wrap", 0.0, count=100), {"*": ""}, gone={"*": 0}),
    Case("silent", Fault("stall", 0.0, seconds=LASTS_S), {"*": SILENT}, gone={"*": LASTING}),
    Case("babbling", Fault("noise", 0.0, seconds=LASTS_S), NOISE, gone={"*": LASTING}),
    Case("wrong baud", Fault("wrong_baud", 0.0, seconds=LASTS_S), NOISE, gone={"*": LASTING}),
    Case("half frames", Fault("half", 0.0, count=5), {"*": "in no frame|wrong check|lost"}, 0.1, {"*": 5}),
    Case("duplicates", Fault("repeated", 0.0, count=3), {"*": "twice"}, 0.1, {"*": 0}),
    Case("backlog", Fault("backlog", 0.0, seconds=BACKLOG_S), {"*": SILENT}, BACKLOG_S, KERNEL),
    Case("two devices", Fault("two_devices", 0.0, seconds=LASTS_S, count=300), {"*": "one device alone"}),
    Case("its twin", Fault("two_devices", 0.0, seconds=LASTS_S, count=0), {"*": "one device alone"}),
    Case("restart", Fault("restart", 0.0, seconds=1.0), {"*": "new beginning"}, 1.0, {"*": 50}),
    Case("lost", Fault("lost", 0.0, count=3), {"*": "samples lost: 3"}, 0.1, {"*": 3}),
    Case("wrong check", Fault("bad_crc", 0.0, count=2), {"*": "wrong check"}, 0.1, {"*": 2}),
    Case("clock jump", Fault("clock_jump", 0.0, seconds=9.0), NO_CLOCK, 0.0, {"*": 0}),
    Case("unplug", Fault("unplug", 0.0, seconds=LASTS_S), GONE, gone={"*": LASTING, "pty": -1}),
)  # fmt: skip


def once_read(chunk: Callable[[int], list[Sent]], port: int) -> Callable[[int], list[Sent]]:
    """Return what takes the next samples of a device on a UDP port once those before have been read."""

    def taken(most: int) -> list[Sent]:
        deadline = time.monotonic() + HANG_S
        while waiting_for_others(port):
            assert time.monotonic() < deadline, f"nobody reads port {port}"
            time.sleep(LOOK_S)
        return chunk(most)

    return taken


def begins_s(case: Case) -> float:
    """Return when a case begins [s]."""
    return 0.0 if case.fault.kind == "counter_wrap" else BEGIN_S + SLOT_S * CASES.index(case)


def back_s(case: Case) -> float:
    """Return how long after its end samples may be missing [s]; a port is opened again in real time."""
    return BACK_S * (SPEED if case.fault.kind == "unplug" else 1.0)


class WatchedFeed(LiveFeed):
    """A feed that keeps what it took: samples, and before which of them something is missing."""

    def __init__(self, reader: Reader, wire: WireFormat, speed: float) -> None:
        self.samples: list[SampleBlock] = []
        self.marked: list[int] = []
        self.taken = 0
        super().__init__(reader, wire, clock=lambda: time.monotonic() * speed)

    def _take(self, chunk: Chunk) -> None:
        super()._take(chunk)
        piece = self._pieces[-1]
        self.marked += (piece.breaks + self.taken).tolist()
        self.samples.append(piece.block)
        self.taken += len(piece.block)


class Run:
    """What a station saw on a transport; ``index`` (n,): which sample of the truth each is, -1 none."""

    def __init__(self, transport: str, folder: Path, speed: float) -> None:
        self.transport, self._speed = transport, speed
        faults = [replace(case.fault, at_s=begins_s(case)) for case in CASES]
        last_s = begins_s(CASES[-1]) + SLOT_S + back_s(CASES[-1])
        memory = SimulatedImu(TRUTH, SEED).read(round(last_s / PERIOD) + 500)
        self._truth = {row.tobytes(): i for i, row in enumerate(np.hstack((memory.gyro, memory.accel)))}
        assert len(self._truth) == len(memory)
        self.reported: list[tuple[int, str]] = []  # by which sample of the truth, and what
        self.heard: list[tuple[float, str]] = []  # when by the station's clock [s], and what
        self.came: list[tuple[float, int]] = []  # when by the same clock, and the newest sample of the truth
        self.blocks: list[IntArray] = []
        link = folder / "imu" if transport in {"pty", "slcan"} else None
        port = free_udp_port() if transport == "udp_multicast" else 0
        with SimulatedDevice(
            TRUTH, SEED, speed=speed, transport=transport, link=link, port=port, faults=faults, hold=True
        ) as device:
            if port:
                device.device.chunk = once_read(device.device.chunk, port)
            with Reader(device.url, folder / "recording.mcap") as reader, BenchControl(device.control) as hands:
                wire = wire_of(reader.address)
                assert wire is not None
                self.feed = WatchedFeed(reader, wire, speed)
                hands.go()
                self._follow(last_s)
                self.is_alive = reader.ended is None
        assert device.failure is None
        self.index = np.concatenate([self.which(block) for block in self.feed.samples])

    def which(self, block: SampleBlock) -> IntArray:
        """Return which samples of the truth these are."""
        rows = np.hstack((block.gyro, block.accel))
        return np.array([self._truth.get(row.tobytes(), -1) for row in rows], dtype=np.int64)

    def _follow(self, last_s: float) -> None:
        feed, newest = self.feed, 0
        deadline = time.monotonic() + HANG_S
        while newest < last_s / PERIOD:
            assert time.monotonic() < deadline, (self.transport, newest * PERIOD, self.reported[-3:])
            try:
                feed.advance()
                if feed.lost:
                    self.reported.append((newest, f"was lost ({feed.lost})"))
            except DriverError as error:
                if not feed.taken:
                    continue  # it has not begun
                self.reported.append((newest, str(error)))
            if feed.taken and len(feed.samples[-1]):
                newest = max(newest, int(self.which(feed.samples[-1])[-1]))
            if feed.trouble:
                self.reported.append((newest, feed.trouble))
            now = time.monotonic() * self._speed
            self.heard += [(now, text) for _, text in self.reported[len(self.heard) :]]
            self.came.append((now, newest))
            if feed.unit is None and feed.taken > 40:
                feed.identify("SIM", None if feed.stream.decoder.serial else "7")
            for block in feed.ready() if feed.unit else ():
                self._keep(block)

    def _keep(self, block: Block) -> None:
        self.blocks.append(self.which(self.feed.buffer.block(block.first, block.last)))

    def texts(self, case: Case) -> list[str]:
        """Return what was said from a case on until the next."""
        first = round(begins_s(case) / PERIOD)
        last = first + round((SLOT_S - 0.5) / PERIOD)
        lead = 200 if case.fault.kind == "unplug" else 30  # what is on its way in a pty is lost with it
        return [text for at, text in self.reported if first - lead <= at < last]


def run_all(speed: float) -> dict[str, Run]:
    """Return a run on each transport, all at once."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor() as pool:
        runs = {}
        for transport in TRANSPORTS:
            (own := Path(folder) / transport).mkdir()
            runs[transport] = pool.submit(Run, transport, own, speed)
        return {transport: run.result() for transport, run in runs.items()}


def has_reported(texts: list[str], pattern: str) -> bool:
    """Say whether one of the texts holds what was expected."""
    return any(re.search(pattern, text) for text in texts)


__all__ = ["CASES", "TRANSPORTS", "Case", "Run", "begins_s", "has_reported", "run_all"]
