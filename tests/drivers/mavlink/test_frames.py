"""MAVLink frames are found in any stream, and nothing else is taken for one."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink.frames import HEARTBEAT, MavlinkFramer, SignatureCheck, fields, signing_time
from tests.benchmarks.hostile_mavlink import a_sender, attack, some_frames

KEY = bytes(range(32))


@given(cuts=st.lists(st.integers(1, 60), max_size=30), noise=st.binary(max_size=20), seed=st.integers(0, 99))
def test_frames_are_found_however_the_stream_is_cut(cuts: list[int], noise: bytes, seed: int) -> None:
    frames = some_frames(random.Random(seed), a_sender(), 6)
    stream, framer, found = noise + b"".join(frames) + bytes(300), MavlinkFramer(), 0
    for size in [*cuts, len(stream)]:
        found += len(framer.feed(stream[:size]))
        stream = stream[size:]
    assert found == 6
    assert framer.counters.skipped_bytes == len(noise) + 300


def test_a_false_start_does_not_swallow_the_frame_after_it() -> None:
    frame = some_frames(random.Random(1), a_sender(), 1)[0]
    framer = MavlinkFramer()
    assert len(framer.feed(b"\xfd\x20\x00\x00" + frame + bytes(280))) == 1
    bare = dialect.MAVLink(None)
    bare.robust_parsing = True
    found = bare.parse_buffer(b"\xfd\x20\x00\x00" + frame + bytes(280)) or []
    assert frame not in [bytes(one.get_msgbuf()) for one in found]  # why there is a framer of our own


def test_mavlink_1_is_read_as_well() -> None:
    mav = a_sender()
    raw = mav.heartbeat_encode(2, 3, 0, 0, 4).pack(mav, force_mavlink1=True)
    (frame,) = MavlinkFramer().feed(raw)
    assert (frame.number, fields(frame)["autopilot"]) == (HEARTBEAT, 3)


def test_zeros_that_mavlink_2_cuts_off_are_put_back() -> None:
    mav = a_sender()
    raw = mav.system_time_encode(1_700_000_000_000_000, 0).pack(mav)
    (frame,) = MavlinkFramer().feed(raw)
    assert len(frame.payload) == 7
    assert fields(frame) == {"time_unix_usec": 1_700_000_000_000_000, "time_boot_ms": 0}


def test_lost_repeated_and_disordered_frames_are_counted() -> None:
    frames = some_frames(random.Random(2), a_sender(), 300)
    framer = MavlinkFramer()
    order = [*frames[:10], frames[9], *frames[13:], frames[40]]  # sequence 255 to 0 is passed
    assert len(framer.feed(b"".join(order))) == 298
    counters = framer.counters
    assert (counters.lost, counters.repeated, counters.disordered) == (3, 1, 1)


@pytest.mark.parametrize("bit", range(0, 8 * 12, 5))
def test_every_single_bit_error_is_noticed(bit: int) -> None:
    raw = bytearray(some_frames(random.Random(3), a_sender(), 1)[0])
    raw[bit // 8] ^= 1 << bit % 8
    framer = MavlinkFramer()
    assert not framer.feed(bytes(raw) + bytes(300))
    counters = framer.counters
    assert counters.frames == 0
    assert counters.skipped_bytes == len(raw) + 300


def _signed(key: bytes, stamp: int) -> bytes:
    mav = a_sender()
    mav.signing.secret_key, mav.signing.sign_outgoing, mav.signing.timestamp = key, True, stamp
    return bytes(mav.heartbeat_encode(2, 3, 0, 0, 4).pack(mav))


def test_a_frame_in_time_and_signed_is_taken_once() -> None:
    now = signing_time()
    framer = MavlinkFramer(SignatureCheck(KEY, now))
    raw = _signed(KEY, now + 5)
    assert len(framer.feed(raw)) == 1
    assert not framer.feed(raw + _signed(KEY, now + 4) + _signed(bytes(32), now + 9))
    unsigned = some_frames(random.Random(4), a_sender(), 2)
    assert not framer.feed(b"".join(unsigned))
    counters = framer.counters
    assert (counters.replayed, counters.bad_signature, counters.unsigned, counters.frames) == (2, 1, 2, 1)


def test_a_stream_that_begins_more_than_a_minute_ago_is_a_replay() -> None:
    now = signing_time()
    framer = MavlinkFramer(SignatureCheck(KEY, now))
    assert not framer.feed(_signed(KEY, now - 61 * 100_000))
    assert len(framer.feed(_signed(KEY, now - 59 * 100_000))) == 1


def test_a_forged_frame_from_the_future_does_not_silence_the_sender() -> None:
    now = signing_time()
    framer = MavlinkFramer(SignatureCheck(KEY, now))
    framer.feed(_signed(KEY, now) + _signed(bytes(32), now + 10**12))
    assert len(framer.feed(_signed(KEY, now + 1))) == 1


def test_damaged_frames_neither_crash_nor_become_data() -> None:
    got = attack(frames=4000, seed=7)
    assert got.crashes == 0
    assert got.wrong <= 2  # 4000 failed checks let 0.06 through by chance
    assert got.lost <= 0.02 * got.intact


@pytest.mark.parametrize(("at", "bad_crc", "unknown"), [(12, 1, 0), (8, 0, 1), (2, 0, 1)])
def test_each_damaged_frame_is_counted_once_and_its_bytes_are_skipped(at: int, bad_crc: int, unknown: int) -> None:
    mav, framer = a_sender(), MavlinkFramer()
    raw = list[bytes]()
    for mav.seq in range(3):
        raw.append(mav.heartbeat_encode(2, 3, 0, 0, 4).pack(mav))
    good, damaged, after = raw
    wrong = bytearray(damaged)  # a byte of the payload, of the number, a flag that nobody knows
    wrong[at] ^= 0x42
    assert not {0xFD, 0xFE} & set(wrong[1:])  # nothing else to begin at
    assert len(framer.feed(good + wrong + after + bytes(300))) == 2
    counters = framer.counters
    assert (counters.frames, counters.bad_crc, counters.unknown) == (2, bad_crc, unknown)
    assert (counters.skipped_bytes, counters.lost) == (len(damaged) + 300, 1)
