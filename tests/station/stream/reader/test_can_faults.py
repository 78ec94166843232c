"""An slcan adapter with faults, read by the reader: told, overcome, and no wrong sample."""

import time
from pathlib import Path

import numpy as np
import pytest

from drivers.ports import wire_of
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.faults import Fault
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.arrays import IntArray
from station.stream.reader import Chunk, Reader, StreamGap
from station.stream.recorder.sample_stream import DecodedChunk, SampleStream
from tests.patience import HANG_S, paced

TRUTH = Truth(sample_period_s=0.01)
LASTS_S = 1.6


class Watched:
    """A faulty device being read up to sample ``last``: its samples and what the reader said."""

    def __init__(self, folder: Path, faults: list[Fault], last: int, speed: float = 1.0) -> None:
        link = folder / "can"
        served = SimulatedDevice(TRUTH, 5, speed=speed, transport="slcan", link=link, faults=faults, hold=True)
        with served as device:
            with Reader(device.url, folder / "recording.mcap") as reader:
                wire = wire_of(reader.address)
                assert wire is not None
                self.stream, self.marks, self.pieces = SampleStream(wire), list[StreamGap](), list[DecodedChunk]()
                with BenchControl(device.control) as hands:
                    hands.go()
                began = time.monotonic()
                while not self.pieces or self.pieces[-1].block.counter[-1] < last:
                    assert time.monotonic() < began + HANG_S
                    for item in reader.poll(0.05):
                        self.take(item)

    def take(self, item: Chunk | StreamGap) -> None:
        if isinstance(item, StreamGap):
            self.marks.append(item)
            self.stream.reset()
            return
        piece = self.stream.take(item)
        if len(piece.block):
            self.pieces.append(piece)

    @property
    def counter(self) -> IntArray:
        return np.concatenate([piece.block.counter for piece in self.pieces])

    def assert_true(self) -> None:
        """Every sample is one that the device took."""
        memory = SimulatedImu(TRUTH, 5).read(1000)
        for name in ("gyro", "accel"):
            got = np.concatenate([getattr(piece.block, name) for piece in self.pieces])
            assert np.array_equal(got, getattr(memory, name)[self.counter]), name


@pytest.mark.parametrize(
    ("kind", "reported"), [("adapter_hangs", "no longer answers"), ("bus_off", "bus-off"), ("unplug", "")]
)
def test_every_fault_of_an_adapter_is_reported_and_overcome(kind: str, reported: str, tmp_path: Path) -> None:
    seen = Watched(tmp_path, [Fault(kind, 0.5, seconds=LASTS_S)], 240, paced(1.0))
    broken = next(i for i, piece in enumerate(seen.pieces) if piece.block.counter[-1] > 200)
    lost, *_, back = seen.marks
    assert not lost.is_open
    assert lost.reason.startswith("port lost: ")
    assert reported in lost.reason
    assert back.is_open
    seen.assert_true()
    gap = int(np.argmax(np.diff(seen.counter)))
    assert seen.counter[gap + 1] - seen.counter[gap] >= LASTS_S / TRUTH.sample_period_s
    assert seen.pieces[broken].restart_at == 0, "what comes after has no relation in time to what was before"


def test_faults_of_frames_are_counted_and_make_no_wrong_sample(tmp_path: Path) -> None:
    kinds = ("frame_lost", "frame_late", "babble", "bad_crc", "repeated", "garbage", "lost", "backlog")
    faults = [Fault(kind, 0.2 + 0.15 * i, count=3, seconds=0.2) for i, kind in enumerate(kinds)]
    seen = Watched(tmp_path, faults, 180)
    seen.assert_true()
    framing, stream = seen.stream.decoder.counters, seen.stream.counters
    assert framing.incomplete >= 1
    assert framing.late >= 6
    assert framing.foreign == 3
    assert framing.bad_crc == 3
    assert seen.marks == []
    assert stream.lost in {7, 8}  # frames lost, checks wrong, samples lost; noise may cost another
    assert np.all(np.diff(seen.counter) > 0)
