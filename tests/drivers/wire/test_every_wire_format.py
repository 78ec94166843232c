"""The contract that every wire format keeps: it is picked up here by being in FORMATS."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.wire import FORMATS, Identity, WireFormat
from procedures.records import CountBlock

every_format = pytest.mark.parametrize("wire", FORMATS.values(), ids=FORMATS)

INT32 = st.one_of(st.sampled_from([-(2**31) + 1, -1, 0, 1, 2**31 - 1]), st.integers(-(2**31) + 1, 2**31 - 1))


@st.composite
def blocks(draw: st.DrawFn) -> CountBlock:
    """Draw what a 32-bit device can have counted."""
    n = draw(st.integers(0, 5))

    def column(values: st.SearchStrategy[int], width: int = 1) -> np.ndarray:
        return np.array(draw(st.lists(values, min_size=n * width, max_size=n * width)), dtype=np.int64)

    temperature = column(st.integers(-32768, 32767)) / 100
    return CountBlock(
        counter=column(st.integers(0, 2**32 - 1)),
        device_time=column(st.integers(0, 2**32)) / 1000,
        gyro=column(INT32, 3).reshape(n, 3),
        accel=column(INT32, 3).reshape(n, 3),
        temperature=np.where(temperature == -327.68, np.nan, temperature),
        status=column(st.integers(0, 2**16 - 1)) & 0xFF00,
        healthy=column(st.integers(0, 1)) > 0,
    )


@every_format
def test_the_key_is_the_name_and_the_documents_are_named(wire: WireFormat) -> None:
    assert FORMATS[wire.name] is wire
    assert wire.title
    assert wire.source
    assert wire.check
    assert wire.baud > 0
    assert wire.carries <= set(CountBlock.__slots__)
    assert ("counter" in wire.carries) == (wire.counter_modulus is not None)


@every_format
def test_every_kind_of_frame_opens_with_the_sync_and_says_its_length(wire: WireFormat) -> None:
    for prefix, kind in wire.kinds.items():
        assert prefix.startswith(wire.sync)
        assert len(wire.sync) <= wire.length_at < len(prefix) == len(wire.imu.prefix)
        assert len(prefix) < kind.size


@every_format
def test_the_example_is_one_intact_frame(wire: WireFormat) -> None:
    assert wire.example.startswith(wire.imu.prefix)
    assert len(wire.example) == wire.imu.size
    assert wire.is_intact(wire.example)
    block = wire.decode(np.frombuffer(wire.example, wire.frame))
    assert len(block) == 1
    assert block.healthy.all()
    assert block.gyro.dtype == block.accel.dtype == block.counter.dtype == np.int64


@every_format
def test_every_single_bit_error_is_noticed(wire: WireFormat) -> None:
    value = int.from_bytes(wire.example, "big")
    for bit in range(8 * len(wire.example)):
        assert not wire.is_intact((value ^ 1 << bit).to_bytes(len(wire.example), "big"))


@every_format
@settings(deadline=None)
@given(block=blocks())
def test_what_is_encoded_is_decoded(wire: WireFormat, block: CountBlock) -> None:
    sent = wire.encode(block)
    assert len(sent) == len(block) * wire.imu.size
    frames = np.frombuffer(sent, wire.frame)
    assert all(wire.is_intact(frame.tobytes()) for frame in frames)
    got = wire.decode(frames)
    np.testing.assert_array_equal(got.gyro, block.gyro)
    np.testing.assert_array_equal(got.accel, block.accel)
    for name in wire.carries - {"status"}:
        np.testing.assert_array_equal(getattr(got, name), getattr(block, name), err_msg=name)
    np.testing.assert_array_equal(got.status & ~0xFF, block.status)  # a lost health may be told in the low byte
    assert wire.encode(got if wire.counter_modulus else block) == sent


@every_format
@pytest.mark.parametrize("channel", ["gyro", "accel"])
@pytest.mark.parametrize("count", [2**31 + 1, -(2**31) - 1, 2**40])
def test_a_count_beyond_32_bits_is_refused(wire: WireFormat, channel: str, count: int) -> None:
    example = wire.decode(np.frombuffer(wire.example, wire.frame))
    fields = {name: getattr(example, name) for name in CountBlock.__slots__}
    fields["counter"] = np.zeros(1, np.int64)
    fields[channel] = np.full((1, 3), count)
    with pytest.raises(ValueError, match=f"{channel}.*expected -2147483648 to 2147483647"):
        wire.encode(CountBlock(**fields))


@every_format
def test_identity_comes_back(wire: WireFormat) -> None:
    if wire.encode_identity is None or wire.identify is None or wire.identity is None:
        pytest.skip(f"{wire.name} sends no identity frame")
    for identity in (Identity("FOG-3A", "0042", 0.0025), Identity("", "", 0.0), Identity("m" * 24, "s" * 24, 1.0)):
        frame = wire.encode_identity(identity)
        assert len(frame) == wire.identity.size
        assert wire.is_intact(frame)
        assert wire.identify(frame) == identity
    for bad in (
        Identity("m" * 25),
        Identity("é"),
        Identity(serial="a\n"),
        Identity(period=-1.0),
        Identity(period=5.0),
    ):
        with pytest.raises(ValueError, match="expected"):
            wire.encode_identity(bad)


@every_format
def test_nominal_scales_have_a_source_and_are_of_a_plausible_size(wire: WireFormat) -> None:
    for model, scale in wire.scales.items():
        assert model == scale.model
        assert scale.source
        assert 50 <= scale.rate_hz <= 2000
        full_scale = 2**31 * scale.rate_hz  # counts per second
        assert 4 < scale.gyro * full_scale < 1e6  # rad/s that 32 bits can hold: the smallest has 262 deg/s
        assert 20 < scale.accel * full_scale < 1e8  # m/s2: 2 g at least
