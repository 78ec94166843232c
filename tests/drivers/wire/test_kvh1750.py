"""KVH 1750 against a genuine frame, its three formats side by side, and strangers with the same header."""

import numpy as np
import pytest

from drivers.framing import Decoder, sniff
from drivers.wire import FORMATS, kvh1750
from drivers.wire.checksums import mpeg2_crc

WIRE = FORMATS["kvh1750"]
# of a real 1750 at rest, kept as a comment in a vehicle project's CRC routine: format A, the CRC is the sensor's
GENUINE = bytes.fromhex(
    "fe81ff55 bc646c1e3c3ff9813b3c1e78 bc065fb7bb2fbd793f7e9800 77470014 168d8b1d"
)  # fmt: skip


def frame(dtype: np.dtype, kind: kvh1750.FrameKind, **fields: object) -> bytes:
    frames = np.zeros(1, dtype)
    frames["header"], frames["status"] = np.frombuffer(kind.prefix, np.uint8), kvh1750.VALID
    for name, value in fields.items():
        frames[name] = value
    body = frames.tobytes()[:-4]
    return body + mpeg2_crc(body).to_bytes(4, "big")


def test_a_genuine_frame_shows_gravity_and_all_axes_valid() -> None:
    decoder = Decoder(WIRE)
    block = decoder.feed(GENUINE)
    assert decoder.kind is kvh1750.A
    assert not decoder.kind.has_time
    assert np.linalg.norm(block.accel) == pytest.approx(0.9945, abs=1e-4)  # g
    assert np.abs(block.gyro).max() < 0.015
    assert (block.counter[0], block.temperature[0], block.status[0]) == (71, 20.0, 0x77)
    assert block.healthy.all()


def test_the_three_formats_may_stand_in_one_stream() -> None:
    stream = b"".join(
        (
            frame(kvh1750.FRAME_A, kvh1750.A, gyro=1.5, sequence=0, temperature=31),
            frame(kvh1750.FRAME_B, kvh1750.B, gyro=2.5, sequence=1, temperature=32, time_us=1_000_000),
            *(frame(kvh1750.FRAME_C, kvh1750.C, gyro=3.5, sequence=2 + i, slot=10 + i) for i in range(4)),
        )
    )
    decoder = Decoder(WIRE)
    block = decoder.feed(stream)
    assert block.gyro[:, 0].tolist() == [1.5, 2.5, 3.5, 3.5, 3.5, 3.5]
    assert np.isnan(block.device_time).tolist() == [True, False, True, True, True, True]
    np.testing.assert_array_equal(block.temperature, [31, 32, np.nan, np.nan, 12, np.nan])
    assert decoder.counters.skipped_bytes == decoder.counters.counter_jumps == 0


@pytest.mark.parametrize("size", [52, 36, 40])
def test_a_stranger_with_the_same_header_is_no_kvh(size: int) -> None:
    rng = np.random.default_rng(size)
    stream = b"".join(kvh1750.A.prefix + rng.bytes(size - 4) for _ in range(100))
    decoder = Decoder(WIRE)
    assert len(decoder.feed(stream)) + len(decoder.finish()) == 0
    assert decoder.counters.bad_crc >= 99
    assert sniff(stream) == []


@pytest.mark.parametrize(
    ("status", "healthy"), [(0x77, True), (0x76, False), (0x37, False), (0xFF, True), (0, False)]
)
def test_an_axis_that_is_not_valid_makes_the_sample_unhealthy(status: int, healthy: bool) -> None:
    block = Decoder(WIRE).feed(frame(kvh1750.FRAME_A, kvh1750.A, status=status))
    assert block.healthy[0] == healthy


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_no_number_is_unhealthy_and_never_reaches_a_sum(value: float) -> None:
    block = Decoder(WIRE).feed(frame(kvh1750.FRAME_B, kvh1750.B, accel=value))
    assert not block.healthy[0]
    assert np.isfinite(block.accel).all()


def test_the_sequence_of_128_wraps_without_a_jump() -> None:
    decoder = Decoder(WIRE)
    decoder.feed(b"".join(frame(kvh1750.FRAME_A, kvh1750.A, sequence=i % 128) for i in range(300) if i != 200))
    assert decoder.counters.counter_jumps == 1
