"""The contract that every wire format keeps: it is picked up here by being in FORMATS."""

import termios
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers import wire as wire_formats
from drivers.wire import FORMATS, Identity, WireFormat
from procedures.counts.sample_records import BLOCK_FIELDS, CountBlock, RateBlock, SampleBlock, block_rows
from tests.drivers.wire.blocks import assert_equal, bare, decoded, each_format, of_format, row_of
from tests.refusals import refused

every_format = each_format()

COUNTED = {f"{w.name}-{c}": (w, c) for w in FORMATS.values() if w.output != "rate" for c in sorted(w.imu.triads)}
INT32 = st.one_of(st.sampled_from([-(2**31) + 1, -1, 0, 1, 2**31 - 1]), st.integers(-(2**31) + 1, 2**31 - 1))


@st.composite
def blocks(draw: st.DrawFn, wire: WireFormat) -> SampleBlock:
    """Draw what a device can have counted, in the bits that its format has."""
    n = draw(st.integers(0, 5))

    def column(values: st.SearchStrategy[int], width: int = 1) -> np.ndarray:
        return np.array(draw(st.lists(values, min_size=n * width, max_size=n * width)), dtype=np.int64)

    temperature = column(st.integers(-32768, 32767)) / 100
    return of_format(
        wire,
        n,
        column(INT32, 3),
        column(INT32, 3),
        counter=column(st.integers(0, 2**32 - 1)),
        device_time=column(st.integers(0, 2**32)) / 1000,
        temperature=np.where(temperature == -327.68, np.nan, temperature),
        status=column(st.integers(0, 2**16 - 1)) & 0xFF00,
        healthy=column(st.integers(0, 1)) > 0,
    )


@pytest.mark.parametrize("name", [module.name for module in iter_modules(wire_formats.__path__)])
def test_every_format_is_in_the_table_under_a_name_of_its_own(name: str) -> None:
    for what, wire in vars(import_module(f"drivers.wire.{name}")).items():
        if isinstance(wire, WireFormat):
            listed = FORMATS.get(wire.name)
            assert listed is not None, (
                f"drivers/wire/{name}.py has {what}, FORMATS of drivers/wire/__init__.py has not"
            )
            assert listed is wire, f"two formats of FORMATS are named {wire.name}"


@every_format
def test_its_speed_is_one_that_a_port_can_be_set_to(wire: WireFormat) -> None:
    assert hasattr(termios, f"B{wire.baud}")


@every_format
def test_the_key_is_the_name_and_the_documents_are_named(wire: WireFormat) -> None:
    assert FORMATS[wire.name] is wire
    assert wire.title
    assert wire.source
    assert wire.check
    assert wire.baud > 0
    assert wire.carries <= set(BLOCK_FIELDS)
    assert ("counter" in wire.carries) == (wire.counter_modulus is not None)


@every_format
def test_every_kind_of_frame_opens_with_a_prefix_of_one_length(wire: WireFormat) -> None:
    for prefix, kind in wire.kinds.items():
        assert len(prefix) == len(wire.imu.prefix)
        assert wire.length_at is None or 0 < wire.length_at < len(prefix)
        assert len(prefix) < kind.size
        assert kind.text is not None or wire.trailer or prefix[:1] not in wire.trailer


@every_format
def test_what_is_measured_and_how_is_reported(wire: WireFormat) -> None:
    assert isinstance(wire.decode(np.zeros(0, wire.frame)), RateBlock if wire.output == "rate" else CountBlock)
    assert ("device_time" in wire.carries) == wire.imu.has_time
    for kind in (wire.imu, *wire.others):
        block = wire.decode(np.zeros(3, kind.dtype))
        assert len(block) == 3
        assert np.isnan(block.device_time).all() or kind.has_time
        assert kind.triads
    # a weak check has a second look behind it, a wrapping time none that turns within a few samples
    assert wire.check_bits >= 16 or wire.max_step is not None
    assert wire.time_modulus is None or wire.time_modulus > 0.1


@every_format
def test_the_example_is_one_intact_frame(wire: WireFormat) -> None:
    assert wire.example.startswith(wire.imu.prefix)
    assert len(wire.example) == wire.imu.size or (wire.imu.text and len(wire.example) <= wire.imu.size)
    assert wire.is_intact(wire.example)
    block = wire.decode(row_of(wire, wire.example))
    assert len(block) == 1
    assert block.healthy.all()
    assert block.counter.dtype == np.int64
    assert block.gyro.dtype == block.accel.dtype == (np.float64 if wire.output == "rate" else np.int64)


@every_format
def test_every_single_bit_error_is_noticed(wire: WireFormat) -> None:
    value = int.from_bytes(wire.example, "big")
    for bit in range(8 * len(wire.example)):
        assert not wire.is_intact((value ^ 1 << bit).to_bytes(len(wire.example), "big"))


@every_format
@settings(max_examples=25)
@given(data=st.data())
def test_what_is_encoded_is_decoded(wire: WireFormat, data: st.DataObject) -> None:
    block = data.draw(blocks(wire))
    if not (np.abs(block.temperature) < 125).all():  # unknown, or as no IMU has it: sent or refused by name
        try:
            wire.encode(block)
        except ValueError as error:
            assert "temperature" in str(error)  # noqa: PT017 - other formats can say it
            block.temperature[:] = 20.0
    sent = wire.encode(block)
    frames = [wire.encode(block_rows(block, slice(row, row + 1))) for row in range(len(block))]
    assert sent == b"".join(frames)
    assert all(len(bare(wire, frame)) == wire.imu.size for frame in frames) or wire.imu.text
    assert all(wire.is_intact(bare(wire, frame)) for frame in frames)
    rows = np.concatenate([np.zeros(0, wire.frame), *(row_of(wire, frame) for frame in frames)])
    got = wire.decode(rows)
    np.testing.assert_array_equal(got.gyro, block.gyro)
    np.testing.assert_array_equal(got.accel, block.accel)
    for name in wire.carries - {"status"}:
        assert_equal(wire, name, getattr(got, name), getattr(block, name))
    if "status" in wire.carries:
        np.testing.assert_array_equal(got.status & ~0xFF, block.status)  # its low byte may tell a fault
    assert wire.encode(got if "counter" in wire.carries else block) == sent
    assert len(decoded(wire, sent)) == len(block)


@pytest.mark.parametrize(("wire", "channel"), COUNTED.values(), ids=COUNTED)
@pytest.mark.parametrize("beyond", [1, 2**40])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_count_beyond_its_bits_is_refused(wire: WireFormat, channel: str, beyond: int, sign: int) -> None:
    example = wire.decode(row_of(wire, wire.example))
    fields = {name: getattr(example, name) for name in BLOCK_FIELDS}
    half = 2 ** (wire.count_bits - 1)
    fields["counter"] = np.zeros(1, np.int64)
    fields[channel] = np.full((1, 3), sign * (half + beyond))
    with pytest.raises(ValueError, match=f"{channel}.*-{half} to {half - 1}"):
        wire.encode(CountBlock(**fields))


@each_format(lambda wire: wire.encode_identity is not None)
def test_identity_comes_back(wire: WireFormat) -> None:
    assert wire.encode_identity is not None
    assert wire.identify is not None
    assert wire.identity is not None
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
        with refused(ValueError):
            wire.encode_identity(bad)


@every_format
def test_nominal_scales_have_a_source_and_are_of_a_plausible_size(wire: WireFormat) -> None:
    for model, scale in wire.scales.items():
        assert model == scale.model
        assert scale.source
        assert 50 <= scale.rate_hz <= 2000
        full_scale = 2 ** (wire.count_bits - 1) * scale.rate_hz  # counts per second
        assert 4 < scale.gyro * full_scale < 1e6  # rad/s that the bits can hold: the smallest has 262 deg/s
        if "accel" in wire.imu.triads:
            assert 20 < scale.accel * full_scale < 1e8  # m/s2: 2 g at least
