"""The raw IMU logs by hand: frames as the manual lays them out, limits, IMU types, weeks, status of the time."""

import struct

import numpy as np
import pytest

from drivers.wire.novatel_binary import MODELS, WEEK_S, decode, gps_seconds, identify, rows, table
from procedures.counts.sample_records import CountBlock
from tests.refusals import refused


def block(**changed: object) -> CountBlock:
    given = {
        "counter": np.array([-1]), "device_time": np.array([2000 * WEEK_S + 5.25]), "gyro": np.array([[1, 2, 3]]),
        "accel": np.array([[4, 5, 6]]), "temperature": np.array([np.nan]), "status": np.array([77]),
        "healthy": np.array([True]),
    }  # fmt: skip
    return CountBlock(**(given | changed))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("is_long", "is_typed", "size"), [(False, False, 56), (False, True, 56), (True, False, 72), (True, True, 72)]
)
def test_a_row_is_laid_out_as_the_manual_says(is_long: bool, is_typed: bool, size: int) -> None:
    """Short header 12 bytes, long one 28; then week, seconds, status, Z -Y X of both triads, CRC."""
    raw = rows(block(), table(is_long=is_long, is_typed=is_typed), 1462).tobytes()
    assert len(raw) == size
    at = 28 if is_long else 12
    if is_long:
        assert raw[:8] == b"\xaa\x44\x12\x1c" + struct.pack("<HBB", 1462, 0, 0)
        assert struct.unpack_from("<HHBBHI", raw, 8) == (40, 0, 0, 180, 2000, 5250)
    else:
        assert raw[:12] == b"\xaa\x44\x13\x28" + struct.pack("<HHI", 1462, 2000, 5250)
    week = struct.unpack_from("<BBH" if is_typed else "<I", raw, at)
    assert week == ((0, 33, 2000) if is_typed else (2000,))
    assert struct.unpack_from("<dI6i", raw, at + 4) == (5.25, 77, 6, -5, 4, 3, -2, 1)


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("status", [2**32 - 1], [2**32]),
        ("status", [0], [-1]),
        ("gyro", [[2**31 - 1, 2**31, 0]], [[2**31, 0, 0]]),
        ("gyro", [[-(2**31), -(2**31) + 1, 0]], [[0, -(2**31), 0]]),
        ("accel", [[0, 2**31, 0]], [[0, 0, -(2**31) - 1]]),
        ("device_time", [65535.0 * WEEK_S], [65536.0 * WEEK_S]),
        ("device_time", [0.0], [-1.0]),
    ],
)
def test_what_a_field_cannot_hold_is_refused(name: str, good: list[object], bad: list[object]) -> None:
    dtype = table(is_long=True, is_typed=True)
    found = decode(rows(block(**{name: np.array(good)}), dtype, 1))
    assert getattr(found, name).tolist() == good
    with refused(ValueError):
        rows(block(**{name: np.array(bad)}), dtype, 1)


@pytest.mark.parametrize("imu_type", [*MODELS, 250])
def test_the_type_names_the_model_and_its_rate(imu_type: int) -> None:
    dtype = table(is_long=False, is_typed=True)
    frames = rows(block(), dtype, 1)
    frames["type"] = imu_type
    found = identify(frames.tobytes(), dtype)
    if imu_type not in MODELS:
        assert (found.model, found.period) == ("NovAtel IMU type 250", 0.0)
        return
    assert found.model == MODELS[imu_type].model
    assert found.period is not None
    assert found.period * MODELS[imu_type].rate_hz == pytest.approx(1.0)


WEEK_S = 604800
TYPES = {
    1: "HG1700 AG11", 4: "HG1700 AG17", 5: "HG1900 CA29", 8: "LN-200", 11: "HG1700 AG58", 12: "HG1700 AG62",
    13: "iMAR FSAS", 16: "KVH COTS", 20: "HG1930 AA99", 26: "ISA-100C", 27: "HG1900 CA50", 28: "HG1930 CA50",
    31: "ADIS16488", 32: "STIM300", 33: "KVH 1750", 41: "Epson EG320N", 52: "LITEF uIMU-IC", 56: "STIM300D",
    58: "HG4930 AN01", 61: "Epson EG370N", 62: "Epson EG320N 200 Hz", 68: "HG4930 AN04", 69: "HG4930 AN04 400 Hz",
}  # fmt: skip


def test_types_are_numbered_as_the_driver_has_them() -> None:
    assert {number: scale.model for number, scale in MODELS.items()} == TYPES
    assert {scale.source for scale in MODELS.values()} == {"OEM7 manual, RAWIMUSX, raw IMU scale factors"}


@pytest.mark.parametrize("is_typed", [False, True])
def test_a_week_of_65536_is_held_by_the_log_without_a_type_alone(is_typed: bool) -> None:
    frames = np.zeros(1, table(is_long=False, is_typed=is_typed))
    frames["week"], frames["seconds"] = 65535, 3.0
    assert decode(frames).device_time.tolist() == [65535 * WEEK_S + 3.0]
    if not is_typed:
        frames["week"] = 2**32 - 1
        assert decode(frames).device_time.tolist() == [(2**32 - 1) * WEEK_S + 3.0]


def test_the_last_millisecond_of_a_week_is_of_that_week() -> None:
    time = np.array([2000 * WEEK_S + WEEK_S - 0.0005, 2001.0 * WEEK_S])
    block = CountBlock(
        counter=np.array([-1, -1]), device_time=time, gyro=np.zeros((2, 3), np.int64),
        accel=np.zeros((2, 3), np.int64), temperature=np.full(2, np.nan), status=np.zeros(2, np.int64),
        healthy=np.ones(2, np.bool_),
    )  # fmt: skip
    frames = rows(block, table(is_long=True, is_typed=False), 268)
    assert frames["week"].tolist() == frames["log_week"].tolist() == [2000, 2001]
    assert frames["log_ms"].tolist() == [604_799_999, 0]


AT = 2400 * WEEK_S + 5.25


def header(status: int) -> bytes:
    """Return the long binary header of the OEM7 manual: 28 bytes, the time status is the 14th."""
    return b"\xaa\x44\x12\x1c" + bytes(9) + bytes([status]) + bytes(14)


def text(status: str) -> bytes:
    return f"#RAWIMUA,COM1,0,60.5,{status},2400,5.250,00,0,0;1,2*abcd\r\n".encode()


CASES = [
    (header(160), False, True),
    (header(180) + bytes(90), False, True),
    (header(159) + bytes(90), False, False),
    (header(60) + bytes(90) + header(180), False, True),  # the last one counts
    (header(180) + bytes(90) + header(60), False, False),
    (header(60) + bytes(90) + header(180)[:12], False, False),  # of those that are whole
    (b"", False, False),
    (text("FINESTEERING"), True, True),
    (text("COARSE") + text("SATTIME"), True, True),
    (text("SATTIME") + text("COARSE"), True, False),
    (text("SATTIME") + text("COARSE")[:40], True, True),
]


@pytest.mark.parametrize(("data", "is_text", "is_known"), CASES, ids=range(len(CASES)))
def test_the_last_whole_header_says_how_good_the_time_is(data: bytes, is_text: bool, is_known: bool) -> None:
    form = gps_seconds(lambda block: b"", is_long=True, is_text=is_text)
    assert form.age(data, AT) == (pytest.approx(0.25) if is_known else None)
    assert form.age(data, 5.25) is None  # a receiver without the time counts from week 0


def test_short_headers_say_nothing_of_the_time_but_its_week() -> None:
    form = gps_seconds(lambda block: b"", is_long=False, is_text=False)
    assert form.age(b"", AT) == pytest.approx(0.25)
    assert form.age(b"", 5.25) is None
