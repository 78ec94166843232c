"""Frames are found however the stream is cut and whatever stands between them; family tests over FORMATS."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.framing import Decoder, sniff
from drivers.wire import FORMATS, Identity, WireFormat
from tests.drivers.wire import blocks
from tests.drivers.wire.blocks import a_block, bare, each_format, gyro_of, sync_of

every_format = each_format()


@cache
def frames_of(wire: WireFormat, n: int) -> list[bytes]:
    return blocks.frames_of(wire, a_block(wire, n))


def fed(wire: WireFormat, *pieces: bytes) -> tuple[Decoder, list[list[float]]]:
    """Feed the pieces; return the decoder and the gyro values that came out."""
    decoder = Decoder(wire)
    found = [decoder.feed(piece) for piece in pieces]
    found.append(decoder.finish())
    return decoder, gyro_of(found)


@cache
def noises(wire: WireFormat) -> st.SearchStrategy[bytes]:
    """Draw what lies between frames: anything, and what looks like the beginning of one."""
    starts = [wire.imu.prefix[:size] for size in range(1, len(wire.imu.prefix) + 1)]
    false = st.one_of(st.binary(max_size=20), st.sampled_from([*starts, wire.example[:-1], wire.example[1:]]))
    return st.lists(false, max_size=3).map(b"".join)


@every_format
@settings(max_examples=25)
@given(data=st.data())
def test_frames_are_found_in_any_noise_however_the_stream_is_cut(wire: WireFormat, data: st.DataObject) -> None:
    stream = b""
    for frame in frames_of(wire, 4):
        # One byte that begins no sync ends the noise: bytes that by chance complete a cut frame would be its own.
        stream += data.draw(noises(wire)) + b"\x00" + frame
    stream += data.draw(noises(wire))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    whole, got_whole = fed(wire, stream)
    cut, got_cut = fed(wire, *pieces)
    single, got_single = fed(wire, *(bytes((octet,)) for octet in stream))
    assert got_whole == got_cut == got_single
    assert whole.counters == cut.counters == single.counters
    sent = a_block(wire, 4).gyro.tolist()
    assert [row for row in got_whole if row in sent] == sent
    if wire.imu.text is None and not wire.trailer:
        assert whole.counters.frames * wire.imu.size + whole.counters.skipped_bytes == len(stream)


@every_format
def test_no_cut_of_two_frames_loses_one(wire: WireFormat) -> None:
    stream = b"".join(frames_of(wire, 2))
    for cut in range(len(stream) + 1):
        decoder, got = fed(wire, stream[:cut], stream[cut:])
        assert got == a_block(wire, 2).gyro.tolist()
        assert decoder.counters.skipped_bytes == 0


@every_format
def test_a_frame_that_is_whole_is_not_held_back(wire: WireFormat) -> None:
    decoder = Decoder(wire)
    for frame in (bare(wire, frame) for frame in frames_of(wire, 3)):
        assert len(decoder.feed(frame[:-1])) == 0
        assert len(decoder.feed(frame[-1:])) == 1


@every_format
def test_a_real_frame_inside_a_falsely_started_one_is_found(wire: WireFormat) -> None:
    first, second = frames_of(wire, 2)
    for size in range(len(wire.imu.prefix), len(bare(wire, first))):
        decoder, got = fed(wire, first[:size] + second + first)
        gyro = a_block(wire, 2).gyro.tolist()
        assert got == [gyro[1], gyro[0]]
        assert decoder.counters.skipped_bytes == size
        # without a sync, a frame holds what may begin others
        assert decoder.counters.bad_crc == 1 or not sync_of(wire)


@every_format
def test_a_frame_with_a_wrong_check_is_never_decoded(wire: WireFormat) -> None:
    frame = bare(wire, frames_of(wire, 1)[0])
    for at in range(len(wire.imu.prefix), len(frame)):
        damaged = frame[:at] + bytes((frame[at] ^ 0x10,)) + frame[at + 1 :]
        decoder, got = fed(wire, damaged)
        assert got == []
        is_cut = wire.imu.text is not None and frame[at : at + 1] == b"*"  # nothing ends the line
        assert decoder.counters.skipped_bytes == len(frame)
        assert decoder.counters.bad_crc == (0 if is_cut else 1) or not sync_of(wire)


@each_format(lambda wire: wire.length_at is not None)
def test_a_known_kind_with_another_length_is_counted(wire: WireFormat) -> None:
    first, second = frames_of(wire, 2)
    wrong = first[: wire.length_at] + bytes((first[wire.length_at] + 1,)) + first[wire.length_at + 1 :]
    decoder, got = fed(wire, wrong + second)
    assert got == a_block(wire, 2).gyro.tolist()[1:]
    assert (decoder.counters.bad_length, decoder.counters.bad_crc) == (1, 0)


@every_format
def test_endless_garbage_takes_no_memory(wire: WireFormat) -> None:
    decoder, rng = Decoder(wire), np.random.default_rng(1)
    for garbage in (rng.bytes(100_000), sync_of(wire) * 30_000, wire.imu.prefix * 20_000, b"\xff\x00" * 50_000):
        decoder.feed(garbage)
        assert len(decoder._pending) < wire.imu.size  # noqa: SLF001 - what is bounded is what is kept
    assert decoder.counters.frames == 0


@each_format(lambda wire: "healthy" in wire.carries)
def test_bad_status_is_counted(wire: WireFormat) -> None:
    block = a_block(wire, 5)
    block.healthy[1:3] = False
    decoder, _ = fed(wire, wire.encode(block))
    assert decoder.counters.bad_status == 2


@each_format(lambda wire: wire.carries & {"counter", "device_time"})
def test_lost_and_repeated_frames_are_counted_however_the_stream_is_cut(wire: WireFormat) -> None:
    sent = frames_of(wire, 200)
    stream = b"".join(sent[:50] + sent[51:100] + [sent[99]] + sent[100:150] + sent[160:])
    for size in (1, 56, 1000, len(stream)):
        decoder, _ = fed(wire, *(stream[at : at + size] for at in range(0, len(stream), size)))
        # Lost, repeated, lost; a counter's repeat is one jump, and so is it in device time.
        assert decoder.counters.counter_jumps == 3


@every_format
def test_sniffing_names_the_format(wire: WireFormat) -> None:
    (likely, *_) = found = sniff(b"\x00\xff" * 20 + b"".join(frames_of(wire, 50)))
    assert likely.format == wire.name
    assert likely.frames == 50
    size = len(b"".join(frames_of(wire, 50)))
    assert likely.share_of_bytes == pytest.approx(size / (40 + size))
    assert len(found) == 1


def test_sniffing_nothing_names_nothing() -> None:
    assert sniff(b"") == sniff(b"\xaa" * 1000) == sniff(np.random.default_rng(2).bytes(10_000)) == []


def test_the_identity_frame_is_found_between_counts() -> None:
    wire = FORMATS["counts"]
    assert wire.encode_identity is not None
    identity = wire.encode_identity(Identity("FOG-3A", "0042", 0.0025))
    first, second, third = frames_of(wire, 3)
    decoder = Decoder(wire)
    assert (decoder.model, decoder.serial) == (None, None)
    assert len(decoder.feed(first + identity + second + identity[:10] + third)) == 2
    assert len(decoder.finish()) == 1  # 58 bytes of the 60 that the cut identity frame promised
    assert (decoder.model, decoder.serial) == ("FOG-3A", "0042")
    assert decoder.counters.identities == 1
    assert decoder.counters.skipped_bytes == 10
    assert decoder.counters.counter_jumps == 0
