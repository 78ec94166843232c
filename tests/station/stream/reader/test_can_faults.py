"""An slcan adapter with faults, read by the reader: told within 2 s, overcome within 3 s, no wrong sample."""

import time
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.imu import SimulatedImu
from drivers.simulated.line_faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.simulated_hands import SimulatedHands
from drivers.simulated.truth import Truth
from drivers.url_wire_format import wire_of
from procedures.arrays import IntArray
from station.stream.reader import Chunk, GapMark, Reader
from station.stream.recorder.sample_stream import SampleStream
from tests.patience import HANG_S, slowness

TRUTH = Truth(sample_period_s=0.01)
LASTS_S, TOLD_S, BACK_S = 1.6, 2.0, 3.0


class Watched:
    """A faulty device being read up to sample ``last``: its samples, what the reader said, and when."""

    def __init__(self, folder: Path, faults: list[Fault], last: int, speed: float = 1.0) -> None:
        link = folder / "can"
        served = SimulatedDevice(TRUTH, 5, speed=speed, transport="slcan", link=link, faults=faults, hold=True)
        with served as device:
            with Reader(device.url, folder / "journal.mcap") as reader:
                wire = wire_of(reader.address)
                assert wire is not None
                self.stream, self.marks = SampleStream(wire), list[tuple[float, GapMark]]()
                self.pieces, self.times = [], list[float]()
                with SimulatedHands(device.control) as hands:
                    hands.go()
                began = time.monotonic()
                while not self.pieces or self.pieces[-1].block.counter[-1] < last:
                    now = time.monotonic() - began
                    assert now < HANG_S
                    for item in reader.poll(0.05):
                        self.take(item, now)

    def take(self, item: Chunk | GapMark, now: float) -> None:
        if isinstance(item, GapMark):
            self.marks.append((now, item))
            self.stream.begin_anew()
            return
        piece = self.stream.take(item)
        if len(piece.block):
            self.pieces.append(piece)
            self.times.append(now)

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
    ("kind", "said"), [("adapter_hangs", "no longer answers"), ("bus_off", "bus-off"), ("unplug", "")]
)
def test_every_fault_of_an_adapter_is_told_and_overcome(kind: str, said: str, tmp_path: Path) -> None:
    slow = slowness()  # the device goes as much slower, and a second may take as much longer
    seen = Watched(tmp_path, [Fault(kind, 0.5, seconds=LASTS_S)], 240, 1 / slow)
    broken = next(i for i, piece in enumerate(seen.pieces) if piece.block.counter[-1] > 200)
    begins_at = seen.times[broken - 1]
    (lost_at, lost), *_, (_, back) = seen.marks
    assert not lost.is_open
    assert lost.reason.startswith("port lost: ")
    assert said in lost.reason
    assert lost_at < begins_at + TOLD_S * slow
    assert back.is_open
    seen.assert_true()
    gap = int(np.argmax(np.diff(seen.counter)))
    assert seen.counter[gap + 1] - seen.counter[gap] >= LASTS_S / TRUTH.sample_period_s
    assert seen.times[broken] < begins_at + (LASTS_S + BACK_S) * slow
    assert seen.pieces[broken].anew == 0, "what comes after has no relation in time to what was before"


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


def test_a_restarted_device_begins_anew(tmp_path: Path) -> None:
    seen = Watched(tmp_path, [Fault("counter_restart", 0.5)], 70)
    assert seen.stream.counters.restarts == 1
    anew = [piece for piece in seen.pieces if piece.anew is not None]
    assert len(anew) == 2, "at the beginning and at the restart"
