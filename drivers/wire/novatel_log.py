"""The four raw IMU logs of NovAtel's receivers, binary: two headers, two bodies, one way to read them.

Short header (12 bytes, ``AA 44 13``): RAWIMUS, RAWIMUSX. Long header (28 bytes, ``AA 44 12``): RAWIMU, RAWIMUX.
The X logs name the IMU type and have an error bit; the others are read as healthy whenever their time is one.
Source: OEM7 manual, "Binary", "Description of ASCII and Binary Logs with Short Headers" and the logs' own pages.
"""

from functools import partial

import numpy as np

from drivers.wire import novatel
from drivers.wire._format import FrameKind, Frames, Identity, WireFormat, fits, seal
from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import CountBlock

KVH_1750 = 33  # what `encode` says it is: a FOG IMU
ERROR, ENCRYPTED = 0x01, 0x02  # IMU info bits; the rest are reserved
BODY_BYTES = 40  # bytes, of every one of these logs
LONG_SYNC, LONG_HEADER = b"\xaa\x44\x12", 28
FINE_STEERING = 180  # OEM7 manual, GPS reference time status

_SHORT = [("sync", "u1", 3), ("length", "u1"), ("id", "<u2"), ("log_week", "<u2"), ("log_ms", "<u4")]
_LONG = [
    ("sync", "u1", 3),
    ("header", "u1"),  # bytes: 28
    ("id", "<u2"),
    ("message_type", "u1"),
    ("port", "u1"),
    ("length", "<u2"),  # of the body
    ("sequence", "<u2"),
    ("idle", "u1"),
    ("time_status", "u1"),
    ("log_week", "<u2"),
    ("log_ms", "<u4"),
    ("receiver_status", "<u4"),
    ("definition", "<u2"),
    ("version", "<u2"),
]
_PLAIN = [("week", "<u4")]
_TYPED = [("info", "u1"), ("type", "u1"), ("week", "<u2")]
_REST = [
    ("seconds", "<f8"),  # into the week
    ("status", "<u4"),  # its meaning depends on the IMU type
    ("accel", "<i4", 3),  # velocity increments Z, -Y, X
    ("gyro", "<i4", 3),  # angle increments Z, -Y, X
    ("crc", "<u4"),
]


def table(*, is_long: bool, is_typed: bool) -> np.dtype[np.void]:
    """Return a log's table in wire order."""
    return np.dtype([*(_LONG if is_long else _SHORT), *(_TYPED if is_typed else _PLAIN), *_REST])


def decode(frames: Frames) -> CountBlock:
    """Return the counts; unhealthy where the IMU error or encrypted bit is set or the time is no time of week."""
    time = novatel.gps_time(frames["week"].astype(np.int64), frames["seconds"])
    healthy = ~np.isnan(time)
    if "info" in (frames.dtype.names or ()):
        healthy &= (frames["info"] & (ERROR | ENCRYPTED)) == 0
    return CountBlock(
        counter=novatel.no_counter(frames),
        device_time=time,
        gyro=novatel.xyz(frames, "gyro"),
        accel=novatel.xyz(frames, "accel"),
        temperature=novatel.unknown_temperature(frames),
        status=frames["status"].astype(np.int64),
        healthy=healthy,
    )


def rows(block: CountBlock, dtype: np.dtype[np.void], message: int) -> Frames:
    """Return a block as rows of a log's table, CRC still 0, as a KVH 1750 (type 33) gives them."""
    frames = np.zeros(len(block), dtype)
    week, seconds = novatel.week_and_seconds(block)
    _fill_header(frames, message, week, seconds)
    frames["week"], frames["seconds"] = week, seconds
    if "info" in (dtype.names or ()):
        frames["info"], frames["type"] = np.where(block.healthy, 0, ERROR), KVH_1750
    frames["status"] = fits(block.status, 0, 2**32 - 1, "status")
    for name, counts in (("accel", block.accel), ("gyro", block.gyro)):
        frames[name] = novatel.z_minus_y_x(counts, name)
    return frames


def encode(block: CountBlock, dtype: np.dtype[np.void], message: int) -> bytes:
    """Return the frames of a block; counter and temperature are not sent, nor health where there is no type."""
    return seal(rows(block, dtype, message), novatel.crc)


def identify(frame: bytes, dtype: np.dtype[np.void]) -> Identity:
    """Return the IMU model that the type byte names; the log has no serial number."""
    imu_type = int(np.frombuffer(frame, dtype)["type"][0])
    scale = novatel.MODELS.get(imu_type)
    if scale is None:
        return Identity(model=f"NovAtel IMU type {imu_type}")
    return Identity(model=scale.model, period=1 / scale.rate_hz)


def binary_log(name: str, message: int, dtype: np.dtype[np.void], page: str, example: bytes) -> WireFormat:
    """Return the wire format of one log, asked for with ``log NAMEb onnew``."""
    is_long, is_typed = "header" in (dtype.names or ()), "type" in (dtype.names or ())
    sync, size = (LONG_SYNC, LONG_HEADER) if is_long else (novatel.SYNC, BODY_BYTES)
    imu = FrameKind(prefix=sync + bytes((size,)) + message.to_bytes(2, "little"), dtype=dtype)
    return WireFormat(
        name=name,
        title=f"NovAtel {name.upper()} {'long' if is_long else 'short'} binary",
        source=f"docs.novatel.com/OEM7, log {page} (message {message})",
        sync=sync,
        length_at=novatel.LENGTH_AT,
        imu=imu,
        check=novatel.CHECK,
        check_bits=32,
        is_intact=novatel.is_intact,
        decode=decode,
        encode=partial(encode, dtype=dtype, message=message),
        carries=novatel.CARRIES | ({"healthy"} if is_typed else set()),
        baud=novatel.BAUD,
        identity=imu if is_typed else None,
        identify=partial(identify, dtype=dtype) if is_typed else None,
        scales=novatel.SCALES,
        example=example,
    )


def _fill_header(frames: Frames, message: int, week: IntArray, seconds: FloatArray) -> None:
    """Fill in the header: week and millisecond of the log."""
    is_long = "header" in (frames.dtype.names or ())
    frames["sync"] = np.frombuffer(LONG_SYNC if is_long else novatel.SYNC, np.uint8)
    frames["length"], frames["id"], frames["log_week"] = BODY_BYTES, message, week
    frames["log_ms"] = (seconds * 1000).astype(np.uint32)
    if is_long:
        frames["header"], frames["time_status"] = LONG_HEADER, FINE_STEERING
