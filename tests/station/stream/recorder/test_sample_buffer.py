"""A step's raw bytes are those of its samples, however the stream was cut into reads."""

import hypothesis.strategies as st
import numpy as np
from hypothesis import given, settings

from drivers.framing import Decoder
from drivers.simulated.device import ByteDevice
from drivers.simulated.line_faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from station.stream.reader import Chunk
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_stream import SampleStream

WIRE = FORMATS["counts"]
FAULTS = [Fault("garbage", 1.06, count=37), Fault("bad_crc", 1.5), Fault("repeated", 2.0), Fault("garbage", 2.9)]


def sent(samples: int) -> bytes:
    device, parts = ByteDevice(Truth.example(1), 1, "counts", FAULTS), list[bytes]()
    while device.samples < samples:
        parts += [part for part in device.chunk(10) if isinstance(part, bytes)]
    return b"".join(parts)


STREAM = sent(180)


@settings(max_examples=60)
@given(
    cuts=st.lists(st.integers(1, 400), min_size=1),
    runs=st.tuples(st.integers(0, 60), st.integers(1, 60), st.integers(1, 20), st.integers(1, 30)),
    forget=st.booleans(),
)
def test_the_bytes_of_any_runs_decode_to_their_samples(
    cuts: list[int], runs: tuple[int, int, int, int], forget: bool
) -> None:
    buffer, stream, at, turn = SampleBuffer(), SampleStream(WIRE), 0, 0
    begin, first, pause, second = runs
    wanted = [(begin, begin + first), (begin + first + pause, begin + first + pause + second)]
    while at < len(STREAM):
        size = cuts[turn % len(cuts)]
        buffer.append(stream.take(Chunk(at, STREAM[at : at + size])))
        at, turn = at + size, turn + 1
        if forget:
            buffer.forget_before(min(begin, buffer.end))
    recorded = list(buffer.recording(wanted))
    samples = np.concatenate([rows.counter for _, rows in recorded])
    decoder = Decoder(WIRE)
    again = decoder.feed(b"".join(chunk.data for chunk, _ in recorded))
    counters = again.counter[np.diff(again.counter, prepend=-1) != 0]  # the repeated frame is in the bytes twice
    assert samples.tolist() == counters.tolist()
    expected = np.concatenate([buffer.block(*run).counter for run in wanted])
    assert samples.tolist() == expected.tolist()


def test_runs_that_follow_each_other_hold_every_byte_of_the_line() -> None:
    buffer, stream, recorded = SampleBuffer(), SampleStream(WIRE), b""
    for at in range(0, len(STREAM), 100):
        buffer.append(stream.take(Chunk(at, STREAM[at : at + 100])))
        while buffer.end - buffer.first >= 5:
            tick = buffer.first, buffer.first + 5
            recorded += b"".join(chunk.data for chunk, _ in buffer.recording([tick]))
            buffer.forget_before(tick[1])
    assert len(recorded) > len(STREAM) - 500
    assert recorded == STREAM[STREAM.index(recorded[:48]) :][: len(recorded)]


def test_a_break_is_where_it_was_in_its_piece_counted_from_the_first_of_all_samples() -> None:
    buffer, stream = SampleBuffer(), SampleStream(WIRE)
    expected, samples = list[int](), 0
    for at in range(0, len(STREAM), 700):
        piece = stream.take(Chunk(at, STREAM[at : at + 700]))
        expected += [samples + one for one in piece.breaks.tolist()]
        samples += len(piece.block)
        buffer.append(piece)
    assert len(expected) > 1
    assert expected[-1] > 50  # in a piece that is not the first
    assert buffer.breaks(0, samples).tolist() == expected
