"""What a form of the binary raw IMU logs says of itself, and the IMU types by number, written out by hand."""

import numpy as np
import pytest

from drivers.wire import FORMATS, Identity
from drivers.wire.novatel_log import MODELS, binary_log, decode, rows, table
from procedures.counts.sample_records import CountBlock

WEEK = 604800
TYPES = {
    1: "HG1700 AG11", 4: "HG1700 AG17", 5: "HG1900 CA29", 8: "LN-200", 11: "HG1700 AG58", 12: "HG1700 AG62",
    13: "iMAR FSAS", 16: "KVH COTS", 20: "HG1930 AA99", 26: "ISA-100C", 27: "HG1900 CA50", 28: "HG1930 CA50",
    31: "ADIS16488", 32: "STIM300", 33: "KVH 1750", 41: "Epson EG320N", 52: "LITEF uIMU-IC", 56: "STIM300D",
    58: "HG4930 AN01", 61: "Epson EG370N", 62: "Epson EG320N 200 Hz", 68: "HG4930 AN04", 69: "HG4930 AN04 400 Hz",
}  # fmt: skip


def test_types_are_numbered_as_the_driver_has_them() -> None:
    assert {number: scale.model for number, scale in MODELS.items()} == TYPES
    assert {scale.source for scale in MODELS.values()} == {"OEM7 manual, RAWIMUSX, raw IMU scale factors"}


@pytest.mark.parametrize(
    ("name", "title", "message", "prefix", "size"),
    [
        ("rawimus", "NovAtel RAWIMUS short binary", 325, "aa441328 4501", 56),
        ("rawimusx", "NovAtel RAWIMUSX short binary", 1462, "aa441328 b605", 56),
        ("rawimu", "NovAtel RAWIMU long binary", 268, "aa44121c 0c01", 72),
        ("rawimux", "NovAtel RAWIMUX long binary", 1461, "aa44121c b505", 72),
    ],
)
def test_a_log_says_how_it_is_read(name: str, title: str, message: int, prefix: str, size: int) -> None:
    wire = FORMATS[name]
    assert (wire.name, wire.title) == (name, title)
    assert wire.source == f"docs.novatel.com/OEM7, log {name.upper()} (message {message})"
    assert (wire.imu.prefix, wire.imu.size) == (bytes.fromhex(prefix), size)
    assert (wire.sync, wire.length_at) == (bytes.fromhex(prefix)[:3], 3)
    assert (wire.check_bits, wire.baud) == (32, 230400)
    assert (
        wire.check == "CRC-32, reflected polynomial EDB88320, initial 0, no final XOR, over everything before it"
    )


@pytest.mark.parametrize(
    ("name", "is_typed"), [("rawimus", False), ("rawimu", False), ("rawimusx", True), ("rawimux", True)]
)
def test_only_a_log_with_a_type_tells_of_health_and_of_who_it_is(name: str, is_typed: bool) -> None:
    wire = FORMATS[name]
    assert wire.carries == {"device_time", "status"} | ({"healthy"} if is_typed else set())
    if is_typed:
        assert wire.identity is wire.imu
        assert wire.identify is not None
        frame = wire.example
        assert isinstance(wire.identify(frame), Identity)
        assert wire.identify(frame).serial in {None, ""}
    else:
        assert (wire.identity, wire.identify) == (None, None)


@pytest.mark.parametrize("is_long", [False, True])
def test_a_log_that_is_made_sends_what_it_reads(is_long: bool) -> None:
    wire = binary_log("mine", 513, b"", is_long=is_long, is_typed=True)
    block = CountBlock(
        counter=np.array([-1, -1]), device_time=np.array([2400 * WEEK + 0.5, 2400 * WEEK + 0.505]),
        gyro=np.array([[1, 2, 3], [-1, -2, -3]]), accel=np.array([[4, 5, 6], [7, 8, 9]]),
        temperature=np.array([np.nan, np.nan]), status=np.array([1, 2]), healthy=np.array([True, False]),
    )  # fmt: skip
    frames = np.frombuffer(wire.encode(block), wire.frame)
    assert frames["id"].tolist() == [513, 513]
    assert all(wire.is_intact(frame.tobytes()) for frame in frames)
    found = wire.decode(frames)
    assert found.gyro.tolist() == block.gyro.tolist()
    assert found.accel.tolist() == block.accel.tolist()
    assert found.healthy.tolist() == [True, False]
    assert np.isnan(found.temperature).all()
    assert wire.pulse is not None
    assert wire.pulse.age(wire.encode(block)[-wire.imu.size :], 2400 * WEEK + 0.505) == pytest.approx(
        0.505, abs=1e-6
    )


@pytest.mark.parametrize("is_typed", [False, True])
def test_a_week_of_65536_is_held_by_the_log_without_a_type_alone(is_typed: bool) -> None:
    frames = np.zeros(1, table(is_long=False, is_typed=is_typed))
    frames["week"], frames["seconds"] = 65535, 3.0
    assert decode(frames).device_time.tolist() == [65535 * WEEK + 3.0]
    if not is_typed:
        frames["week"] = 2**32 - 1
        assert decode(frames).device_time.tolist() == [(2**32 - 1) * WEEK + 3.0]


def test_the_last_millisecond_of_a_week_is_of_that_week() -> None:
    time = np.array([2000 * WEEK + WEEK - 0.0005, 2001.0 * WEEK])
    block = CountBlock(
        counter=np.array([-1, -1]), device_time=time, gyro=np.zeros((2, 3), np.int64),
        accel=np.zeros((2, 3), np.int64), temperature=np.full(2, np.nan), status=np.zeros(2, np.int64),
        healthy=np.ones(2, np.bool_),
    )  # fmt: skip
    frames = rows(block, table(is_long=True, is_typed=False), 268)
    assert frames["week"].tolist() == frames["log_week"].tolist() == [2000, 2001]
    assert frames["log_ms"].tolist() == [604_799_999, 0]
