"""Every break in the sequence is seen, repeats are dropped, and a step's raw bytes are those of its samples."""

from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
from hypothesis import given, settings

from drivers.framing import Decoder
from drivers.simulated.corrupted_frames import other_unit
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.counts.sample_records import block_rows
from station.stream.reader import Chunk
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_stream import DecodedChunk, SampleStream

WIRE = FORMATS["counts"]


def pieces(*faults: Fault, samples: int = 200) -> tuple[SampleStream, list[DecodedChunk]]:
    device, stream, found = (
        ByteDevice(Truth.example(1), 1, "counts", faults),
        SampleStream(WIRE),
        list[DecodedChunk](),
    )
    while device.samples < samples:
        found += [stream.take(Chunk(device.samples, part)) for part in device.chunk(10) if isinstance(part, bytes)]
    return stream, found


def counters(found: list[DecodedChunk]) -> list[int]:
    return [int(c) for piece in found for c in piece.block.counter]


def test_a_whole_stream_has_no_break_but_its_beginning() -> None:
    stream, found = pieces()
    assert counters(found) == list(range(200))
    assert [i for i, piece in enumerate(found) if piece.restart_at is not None] == [1]  # after the identity frame
    assert stream.counters.breaks == stream.counters.repeated == stream.counters.restarts == 0
    assert stream.period == 0.02


def test_a_lost_frame_is_a_break() -> None:
    stream, found = pieces(Fault("lost", at_s=1.06, count=3))
    assert (stream.counters.lost, stream.counters.breaks) == (3, 1)
    breaks = [int(piece.block.counter[b]) for piece in found for b in piece.breaks if piece.restart_at is None]
    assert breaks == [56]


def test_a_repeated_frame_is_dropped_and_counted() -> None:
    stream, found = pieces(Fault("repeated", at_s=1.06, count=2))
    assert stream.counters.repeated == 2
    assert counters(found) == list(range(200))


def test_a_device_that_counts_from_0_again_restarts_there() -> None:
    stream, found = pieces(Fault("counter_restart", at_s=1.06))
    assert stream.counters.restarts == 1
    restarted = [
        int(piece.block.counter[piece.restart_at]) % 2**32 for piece in found[2:] if piece.restart_at is not None
    ]
    assert restarted == [0]


def test_a_counter_that_wraps_is_no_break() -> None:
    block = ByteDevice(Truth.example(1), 1, "counts").imu.read(10)
    sent = WIRE.encode(replace(block, counter=block.counter + 2**32 - 5))
    stream = SampleStream(WIRE)
    piece = stream.take(Chunk(0, sent))
    assert np.all(np.diff(piece.block.counter) == 1)
    assert stream.counters.breaks == stream.counters.restarts == 0


def test_device_time_that_jumps_is_a_break_though_the_counter_goes_on() -> None:
    block = ByteDevice(Truth.example(1), 1, "counts").imu.read(60)
    later = replace(block, device_time=block.device_time + 5.0 * (np.arange(60) >= 50))
    stream = SampleStream(WIRE)
    piece = stream.take(Chunk(0, WIRE.encode(later)))
    assert piece.breaks.tolist() == [0, 50]


def test_two_frames_of_one_number_that_differ_are_breaks_on_both_sides() -> None:
    block = ByteDevice(Truth.example(1), 1, "counts").imu.read(60)
    frames = [WIRE.encode(block_rows(block, slice(i, i + 1))) for i in range(60)]
    other = WIRE.encode(other_unit(block_rows(block, slice(20, 21)), 0))
    sent = [*frames[:21], other, *frames[21:]]
    for cut in (1, 21, 22, 61):  # however it comes
        stream, breaks, at = SampleStream(WIRE), list[int](), 0
        for i in range(0, len(sent), cut):
            piece = stream.take(Chunk(0, b"".join(sent[i : i + cut])))
            breaks += (piece.breaks + at).tolist()
            at += len(piece.block)
        assert stream.counters.contradicted == 1
        assert breaks[-1] == 21
        assert breaks[:-1] == ([0] if cut in {1, 21} else [0, 20])  # what was given out already cannot be marked


def test_samples_are_numbered_on_and_only_a_gap_of_time_breaks_them() -> None:
    wire = FORMATS["rawimusx"]
    imu, stream = SimulatedImu(Truth.example(3), seed=1), SampleStream(wire)
    sent = [wire.encode(imu.read(50)) for _ in range(6)]
    pieces = [stream.take(Chunk(k, part)) for k, part in enumerate([*sent[:3], *sent[4:]])]  # the fourth is lost
    assert np.all(np.diff(np.concatenate([piece.block.counter for piece in pieces])) == 1)
    assert [piece.breaks.tolist() for piece in pieces] == [[0], [], [], [0], []]
    assert [piece.restart_at for piece in pieces] == [0, None, None, None, None]
    counted = stream.counters
    assert (counted.samples, counted.breaks, counted.restarts, counted.lost) == (250, 1, 0, 0)


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
