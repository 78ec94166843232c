"""The raw IMU logs' fields by hand: axes, signs, GPS time, health, limits, frames as the manual lays them out."""

import struct

import numpy as np
import pytest

from drivers.wire import novatel_log
from drivers.wire.novatel_log import MODELS, decode, identify, rows, table
from procedures.counts.sample_records import CountBlock

WEEK = 604800


def block(**changed: object) -> CountBlock:
    given = {
        "counter": np.array([-1]), "device_time": np.array([2000 * WEEK + 5.25]), "gyro": np.array([[1, 2, 3]]),
        "accel": np.array([[4, 5, 6]]), "temperature": np.array([np.nan]), "status": np.array([77]),
        "healthy": np.array([True]),
    }  # fmt: skip
    return CountBlock(**(given | changed))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("is_long", "is_typed", "size"),
    [
        (False, False, 56),
        (False, True, 56),
        (True, False, 72),
        (True, True, 72),
    ],
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


@pytest.mark.parametrize("is_typed", [False, True])
def test_what_is_encoded_is_decoded(is_typed: bool) -> None:
    found = decode(rows(block(), table(is_long=False, is_typed=is_typed), 1))
    assert (found.gyro.tolist(), found.accel.tolist()) == ([[1, 2, 3]], [[4, 5, 6]])
    assert found.device_time.tolist() == [2000 * WEEK + 5.25]
    assert (found.status.tolist(), found.healthy.tolist(), found.counter.tolist()) == ([77], [True], [-1])


@pytest.mark.parametrize(
    ("seconds", "is_time"),
    [
        (0.0, True),
        (-1e-9, False),
        (WEEK - 1e-6, True),
        (float(WEEK), False),
        (np.nan, False),
        (np.inf, False),
    ],
)
def test_a_time_is_one_of_the_week(seconds: float, is_time: bool) -> None:
    frames = rows(block(), table(is_long=False, is_typed=False), 1)
    frames["seconds"] = seconds
    found = decode(frames)
    assert found.healthy.tolist() == [is_time]
    assert np.isfinite(found.device_time).tolist() == [is_time]


@pytest.mark.parametrize(
    ("info", "is_healthy"), [(0, True), (1, False), (2, False), (3, False), (4, True), (0xFC, True)]
)
def test_the_error_and_the_encrypted_bit_are_told(info: int, is_healthy: bool) -> None:
    frames = rows(block(), table(is_long=False, is_typed=True), 1)
    frames["info"] = info
    assert decode(frames).healthy.tolist() == [is_healthy]
    sick = rows(block(healthy=np.array([False])), table(is_long=False, is_typed=True), 1)
    assert sick["info"].tolist() == [1]


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("status", [2**32 - 1], [2**32]),
        ("status", [0], [-1]),
        ("gyro", [[2**31 - 1, 2**31, 0]], [[2**31, 0, 0]]),
        ("gyro", [[-(2**31), -(2**31) + 1, 0]], [[0, -(2**31), 0]]),
        ("accel", [[0, 2**31, 0]], [[0, 0, -(2**31) - 1]]),
        ("device_time", [65535.0 * WEEK], [65536.0 * WEEK]),
        ("device_time", [0.0], [-1.0]),
    ],
)
def test_what_a_field_cannot_hold_is_refused(name: str, good: list[object], bad: list[object]) -> None:
    dtype = table(is_long=True, is_typed=True)
    found = decode(rows(block(**{name: np.array(good)}), dtype, 1))
    assert getattr(found, name).tolist() == good
    with pytest.raises(ValueError, match="expected"):
        rows(block(**{name: np.array(bad)}), dtype, 1)


def test_a_time_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="device_time is not finite"):
        rows(block(device_time=np.array([np.nan])), table(is_long=False, is_typed=False), 1)


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


def test_the_crc_is_zero_over_a_message_and_its_own() -> None:
    frame = novatel_log.encode(block(), table(is_long=False, is_typed=True), 1462)
    assert novatel_log.is_intact(frame)
    assert not novatel_log.is_intact(frame[:-1] + bytes([frame[-1] ^ 1]))
    register = 0  # bit by bit, as the manual's own code
    for octet in frame[:-4]:
        register ^= octet
        for _ in range(8):
            register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
    assert struct.unpack("<I", frame[-4:]) == (register,)
