"""Signals by place against cantools, for any layout; checks against published values."""

import hypothesis.strategies as st
import numpy as np
import pytest
from cantools.database.can import Message
from cantools.database.can.signal import Signal
from cantools.database.conversion import BaseConversion
from hypothesis import given, settings

from drivers.can.dbc_signals import SignalField, payloads_of, words_of
from drivers.can.mapping_file import CHECKS


@st.composite
def signals(draw: st.DrawFn) -> Signal:
    """A signal anywhere in 8 bytes, in either byte order."""
    is_big = draw(st.booleans())
    is_float = draw(st.integers(0, 4)) == 0
    bits = draw(st.sampled_from((16, 32, 64))) if is_float else draw(st.integers(1, 63))
    low = draw(st.integers(0, 64 - bits))
    start = low if not is_big else 8 * (low // 8) + 7 - low % 8
    is_signed = draw(st.booleans()) and not is_float
    scale, offset = draw(st.sampled_from((1, 0.001, -2.5))), draw(st.sampled_from((0, -40)))
    order = "big_endian" if is_big else "little_endian"
    conversion = BaseConversion.factory(scale, offset, None, is_float)
    return Signal("s", start, bits, order, is_signed, conversion=conversion)


def field_like(signal: Signal) -> SignalField:
    return SignalField(
        signal.start, signal.length, signal.byte_order == "big_endian", signal.is_signed, signal.is_float,
        float(signal.scale), float(signal.offset),
    )  # fmt: skip


@settings(max_examples=100)
@given(signal=signals(), payload=st.binary(min_size=8, max_size=8))
def test_any_signal_reads_as_cantools_reads_it(signal: Signal, payload: bytes) -> None:
    message, field = Message(1, "m", 8, [signal], strict=True), field_like(signal)
    words = words_of(np.frombuffer(payload * 3, np.uint8).reshape(3, 8))
    scaled = message.decode(payload)["s"]
    # cantools scales in whole numbers where it can: beyond 2^53 it rounds once, we twice
    np.testing.assert_allclose(field.value(words), np.full(3, float(scaled)), rtol=1e-15, atol=0)
    if not signal.is_float:
        assert field.raw(words).tolist() == 3 * [message.decode(payload, scaling=False)["s"]]


@settings(max_examples=100)
@given(signal=signals().filter(lambda signal: not signal.is_float), data=st.data())
def test_what_is_put_is_read_and_the_bits_are_those_of_cantools(signal: Signal, data: st.DataObject) -> None:
    half = 1 << (signal.length - 1)
    low, high = (-half, half - 1) if signal.is_signed else (0, 2 * half - 1)
    value, field = data.draw(st.integers(low, high)), field_like(signal)
    words = np.zeros(1, np.uint64), np.zeros(1, np.uint64)
    field.put(words, np.array([value]))
    octets = payloads_of(words)
    assert octets.tobytes() == Message(1, "m", 8, [signal]).encode({"s": value}, scaling=False)
    assert field.raw(words_of(octets)).tolist() == [value]


@pytest.mark.parametrize(("name", "expected"), [("crc8-autosar", 0xDF), ("crc8-j1850", 0x4B), ("xor8", 0x31)])
def test_checks_give_their_published_value(name: str, expected: int) -> None:
    octets = np.frombuffer(b"123456789", np.uint8).reshape(1, -1)
    assert CHECKS[name](np.zeros(1, np.uint32), octets).tolist() == [expected]


@pytest.mark.parametrize(
    ("payload", "autosar", "j1850"),
    [
        ("00000000", 0x12, 0x59),
        ("f20183", 0xC2, 0x37),
        ("0faa0055", 0xC6, 0x79),
        ("00ff5511", 0x77, 0xB8),
        ("332255aabbccddeeff", 0x11, 0xCB),
        ("926b55", 0x33, 0x8C),
        ("ffffffff", 0x6C, 0x74),
    ],
)
def test_checks_give_the_values_of_autosars_tables(payload: str, autosar: int, j1850: int) -> None:
    """AUTOSAR, Specification of CRC Routines, CRC8H2F and CRC8: polynomial 30 too gives DF."""
    octets = np.frombuffer(bytes.fromhex(payload), np.uint8).reshape(1, -1)
    found = [CHECKS[name](np.zeros(1, np.uint32), octets).tolist() for name in ("crc8-autosar", "crc8-j1850")]
    assert found == [[autosar], [j1850]]


def test_the_check_of_our_frames_covers_the_identifier_too() -> None:
    check, octets = CHECKS["crc8-autosar-id"], np.zeros((1, 7), np.uint8)
    seen = {int(check(np.array([each], np.uint32), octets)[0]) for each in range(0x1A0, 0x1A8)}
    assert len(seen) == 8
