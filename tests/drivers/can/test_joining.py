"""Frames to samples: whatever is lost, late, doubled or foreign, no sample is made of frames of two."""

from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from drivers.can import frame_record
from drivers.framing import Decoder
from procedures.counts.sample_records import CountBlock
from tests.drivers.can.frames import RECORD_BYTES, WIRE, frames_of, samples

N = 60
BLOCK = samples(N, first=65500)
FRAMES = frames_of(BLOCK)
TRUTH = {
    int(c) % 65536: (g.tolist(), a.tolist())
    for c, g, a in zip(BLOCK.counter, BLOCK.gyro, BLOCK.accel, strict=True)
}


def fed(stream: bytes, decoder: Decoder, cuts: tuple[int, ...] = (10**9,)) -> CountBlock:
    blocks, at, turn = list[CountBlock](), 0, 0
    while at < len(stream):
        size = cuts[turn % len(cuts)]
        blocks.append(decoder.feed(stream[at : at + size]))
        at, turn = at + size, turn + 1
    names = ("counter", "device_time", "gyro", "accel", "temperature", "status", "healthy")
    return CountBlock(**{name: np.concatenate([getattr(block, name) for block in blocks]) for name in names})


def assert_true(block: CountBlock) -> None:
    for counter, gyro, accel in zip(block.counter, block.gyro, block.accel, strict=True):
        assert TRUTH[int(counter)] == (gyro.tolist(), accel.tolist())
    assert len(set(block.counter.tolist())) == len(block)


@settings(max_examples=12)
@given(cuts=st.lists(st.integers(1, 2000), min_size=1).filter(lambda cuts: np.mean(cuts) > 100))
def test_all_samples_are_found_however_the_stream_is_cut(cuts: list[int]) -> None:
    decoder = Decoder(WIRE)
    block = fed(WIRE.encode(BLOCK), decoder, tuple(cuts))
    assert_true(block)
    assert len(block) == N == decoder.counters.frames
    assert decoder.counters.counter_jumps == 0
    np.testing.assert_allclose(np.diff(block.device_time), 0.002, atol=1e-9)
    assert block.temperature[BLOCK.counter % 250 == 0] == pytest.approx([25.31])


@settings(max_examples=30)
@given(
    lost=st.sets(st.integers(0, 6 * N - 1), max_size=12),
    doubled=st.sets(st.integers(0, 6 * N - 1), max_size=6),
    swapped=st.lists(st.integers(0, 6 * N - 7), max_size=6),
    cuts=st.lists(st.integers(100, 6000), min_size=1, max_size=4),
)
def test_no_sample_is_made_of_two_and_only_those_touched_are_missing(
    lost: set[int], doubled: set[int], swapped: list[int], cuts: list[int]
) -> None:
    order = list(range(6 * N))
    for at in swapped:  # a frame comes up to six places late
        order[at], order[at + 6] = order[at + 6], order[at]
    stream = b"".join((1 + (i in doubled)) * FRAMES[i] for i in order if i not in lost)
    decoder = Decoder(WIRE)
    block = fed(stream, decoder, tuple(cuts))
    assert_true(block)
    touched = {i // 6 for i in lost} | {(at + k) // 6 for at in swapped for k in (0, 6)}
    missing = set(range(N)) - {(int(c) - 65500) % 65536 for c in block.counter}
    assert missing <= touched | {N - 1}, "an untouched sample is missing"
    if lost and missing - {N - 2, N - 1}:  # which may still wait for what is lost
        assert decoder.counters.incomplete > 0


def test_foreign_remote_and_error_frames_are_counted_and_harm_nothing() -> None:
    babble = [
        frame_record.pack(0x123, 0, b"hello"),
        frame_record.pack(0x1A0 | frame_record.EXTENDED, 0, bytes(8)),
        frame_record.pack(0x1A0 | frame_record.REMOTE, 0, b""),
        frame_record.pack(0x40 | frame_record.ERROR, 0, bytes(8)),
    ]
    decoder = Decoder(WIRE)
    block = fed(b"".join(frame + babble[i % 4] for i, frame in enumerate(FRAMES)), decoder)
    assert_true(block)
    assert (len(block), decoder.counters.foreign, decoder.counters.bus_errors) == (N, 180, 180)


def test_a_wrong_frame_that_passes_its_check_is_marked_by_its_step() -> None:
    """Eight bits let one in 256 through; a count far from the one before is then not believed."""
    still = replace(BLOCK, gyro=np.zeros((N, 3), np.int64), accel=np.zeros((N, 3), np.int64))
    jumped = replace(still, gyro=np.where(np.arange(N)[:, None] == 20, 2**28, still.gyro))
    decoder = Decoder(WIRE)
    block = fed(b"".join(frames_of(jumped)), decoder)
    assert np.flatnonzero(~block.healthy).tolist() == [20]
    assert decoder.counters.bad_status == 1


def test_a_restarted_device_begins_again() -> None:
    decoder = Decoder(WIRE)
    block = fed(b"".join([*FRAMES, *frames_of(samples(20, first=0))]), decoder)
    assert len(block) == N + 20
    assert decoder.counters.counter_jumps == 1
    assert np.count_nonzero(np.diff(block.device_time) <= 0) in {0, 1}


def test_a_burst_after_5_s_is_no_gap() -> None:
    """Frames held up for 5 s and handed over at once keep their places."""
    times = (BLOCK.device_time * 1e9).astype(int)
    held = [
        frame_record.pack(identifier, int(times[i // 6]) if i < 120 else int(times[-1]) + 5 * 10**9, data)
        for i, (identifier, data) in enumerate(frame_record.unpack(b"".join(FRAMES)))
    ]
    block = fed(b"".join(held), Decoder(WIRE))
    np.testing.assert_allclose(np.diff(block.device_time), 0.002, atol=1e-9)


def test_two_devices_with_the_same_counter_are_not_mixed() -> None:
    other = frames_of(samples(N, first=65500, seed=2))
    mixed = b"".join(frame for pair in zip(FRAMES, other, strict=True) for frame in pair)
    assert len(fed(mixed, Decoder(WIRE))) == 0


def test_a_record_with_any_bit_wrong_is_refused() -> None:
    for bit in range(8 * RECORD_BYTES):
        spoilt = bytearray(FRAMES[0])
        spoilt[bit // 8] ^= 1 << bit % 8
        assert not (spoilt.startswith(frame_record.IMU.prefix) and WIRE.is_intact(spoilt))
