import numpy as np
import pytest

from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from station.stream.reader.messages import Chunk
from station.stream.recorder.sample_stream import SampleStream


def test_a_rate_other_than_the_model_s_usual_one_is_measured_and_no_break() -> None:
    wire = FORMATS["rawimusx"]  # states the model's 200 Hz; the device sends at 50 Hz
    imu, stream = SimulatedImu(Truth.example(3), seed=1), SampleStream(wire)
    pieces = [stream.take(Chunk(k, wire.encode(imu.read(50)))) for k in range(20)]
    assert stream.period == pytest.approx(0.02)
    assert stream.counters.breaks == 0
    assert np.concatenate([piece.block.counter for piece in pieces]).size == 1000


def test_samples_are_numbered_on_and_only_a_gap_of_time_breaks_them() -> None:
    wire = FORMATS["rawimusx"]
    imu, stream = SimulatedImu(Truth.example(3), seed=1), SampleStream(wire)
    sent = [wire.encode(imu.read(50)) for _ in range(6)]
    pieces = [stream.take(Chunk(k, part)) for k, part in enumerate([*sent[:3], *sent[4:]])]  # the fourth is lost
    assert np.all(np.diff(np.concatenate([piece.block.counter for piece in pieces])) == 1)
    assert [piece.breaks.tolist() for piece in pieces] == [[0], [], [], [0], []]
    assert [piece.anew for piece in pieces] == [0, None, None, None, None]
    counted = stream.counters
    assert (counted.samples, counted.breaks, counted.restarts, counted.lost) == (250, 1, 0, 0)
