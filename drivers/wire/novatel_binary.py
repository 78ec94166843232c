"""The four raw IMU logs of NovAtel's receivers: headers, bodies, CRC, axis order, GPS time and scale factors.

Sources: OEM7 manual (docs.novatel.com/OEM7), "Binary", "Description of ASCII and Binary Logs with Short Headers",
"32-Bit CRC", "GPS Reference Time Status" and the logs' own pages; IMU type ids: novatel_oem7_driver, oem7_imu.hpp.
RAWIMU and RAWIMUS neither name the IMU nor have an error bit: a frame is healthy whenever its time is one.

The whole seconds of GPS time are as good as a pulse (PPS): the receiver stamps samples by it. One that does not
know the time counts from week 0; a long header says how good the time is (160 FINE, 180 FINESTEERING ...).
"""

import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from drivers.wire.checksums import seal
from drivers.wire.wire_format import (
    FrameKind,
    Frames,
    Identity,
    NominalScale,
    Octets,
    PulseForm,
    WireFormat,
    fits,
)
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock
from procedures.units import M_PER_FT, RAD_PER_ARCSEC, RAD_PER_DEG, STANDARD_GRAVITY

WEEK_S = 604800  # s
LONG_SYNC = b"\xaa\x44\x12"
STATUS_AT = 13  # of the long binary header
FINE = 160
STATUS_FIELD = 4  # of the long header's text, by commas
FINE_WORDS = ([b"FINE"], [b"FINEBACKUPSTEERING"], [b"FINESTEERING"], [b"SATTIME"])
SIMULATED_WEEK = 2400


def gps_seconds(encode: Callable[[CountBlock], bytes], *, is_long: bool, is_text: bool) -> PulseForm:
    """Return how a log, sent by ``encode``, reports whole seconds."""
    is_fine = (_says_fine if is_text else _is_fine) if is_long else (lambda data: True)

    def age(data: bytes, sample_s: float) -> float | None:
        return sample_s % 1.0 if sample_s >= WEEK_S and is_fine(data) else None

    def mark(block: CountBlock, ages: FloatArray) -> bytes:
        whole = np.rint(block.device_time - ages)
        return encode(replace(block, device_time=SIMULATED_WEEK * WEEK_S + whole + ages))

    return PulseForm(age, mark)


def _is_fine(data: bytes) -> bool:
    at = data.rfind(LONG_SYNC, 0, max(len(data) - STATUS_AT, 0)) + STATUS_AT
    return at >= STATUS_AT and data[at] >= FINE


def _says_fine(data: bytes) -> bool:
    line = data.rpartition(b"*")[0].rpartition(b"#")[2]  # the last whole one
    return line.split(b",", STATUS_FIELD + 1)[STATUS_FIELD : STATUS_FIELD + 1] in FINE_WORDS


KVH_1750 = 33  # what `encode` says it is: a FOG IMU
ERROR, ENCRYPTED = 0x01, 0x02  # IMU info bits; the rest are reserved
BODY_BYTES = 40  # bytes, of every one of these logs
LONG_HEADER = 28  # bytes
FINE_STEERING = 180  # OEM7 manual, GPS reference time status
SHORT_SYNC = b"\xaa\x44\x13"
LENGTH_AT = 3  # of the short header: the body's; of the long one: the header's own
CHECK = "CRC-32, reflected polynomial EDB88320, initial 0, no final XOR, over everything before it"
INT32 = 2**31
Z_MINUS_Y_X = np.array([1, -1, 1])  # signs, either way; in int64, as in 32 bits -(-2^31) would overflow
BAUD = 230400  # 56 bytes x 200 Hz x 10 bits = 112 kbit/s
CARRIES = frozenset({"device_time", "status"})

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


def crc(data: Octets) -> int:
    """Return NovAtel's CRC-32: zlib's register started at 0 and not inverted at the end."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def is_intact(frame: Octets) -> bool:
    """Say whether a frame passes: the CRC over a message and its own little-endian CRC is 0."""
    return zlib.crc32(frame, 0xFFFFFFFF) == 0xFFFFFFFF


def decode(frames: Frames) -> CountBlock:
    """Return the counts; unhealthy where the IMU error or encrypted bit is set or the time is no time of week.

    Time is in seconds since 1980-01-06, so that it rises over the change of week; double precision keeps 0.24 us.
    """
    seconds = frames["seconds"]
    with np.errstate(invalid="ignore", over="ignore"):
        is_time = (seconds >= 0) & (seconds < WEEK_S)
        time = np.where(is_time, frames["week"].astype(np.int64) * WEEK_S + seconds, np.nan)
    healthy = is_time.copy()
    if "info" in (frames.dtype.names or ()):
        healthy &= (frames["info"] & (ERROR | ENCRYPTED)) == 0
    return CountBlock(
        counter=np.full(len(frames), -1, dtype=np.int64),
        device_time=time,
        gyro=frames["gyro"][:, ::-1] * Z_MINUS_Y_X,
        accel=frames["accel"][:, ::-1] * Z_MINUS_Y_X,
        temperature=np.full(len(frames), np.nan),
        status=frames["status"].astype(np.int64),
        healthy=healthy,
    )


def rows(block: CountBlock, dtype: np.dtype[np.void], message: int) -> Frames:
    """Return a block as rows of a log's table, CRC still 0, as a KVH 1750 (type 33) gives them.

    Raises ValueError for a count or a time that they cannot hold.
    """
    if not np.isfinite(block.device_time).all():
        raise ValueError("device_time is not finite; this format sends a time with every frame")
    week = fits(np.floor_divide(block.device_time, WEEK_S), 0, 2**16 - 1, "GPS week")
    seconds = block.device_time - week * WEEK_S
    names = dtype.names or ()
    frames = np.zeros(len(block), dtype)
    frames["sync"] = np.frombuffer(LONG_SYNC if "header" in names else SHORT_SYNC, np.uint8)
    frames["length"], frames["id"], frames["log_week"] = BODY_BYTES, message, week
    frames["log_ms"] = (seconds * 1000).astype(np.uint32)
    if "header" in names:
        frames["header"], frames["time_status"] = LONG_HEADER, FINE_STEERING
    frames["week"], frames["seconds"] = week, seconds
    if "info" in names:
        frames["info"], frames["type"] = np.where(block.healthy, 0, ERROR), KVH_1750
    frames["status"] = fits(block.status, 0, 2**32 - 1, "status")
    for name, counts in (("accel", block.accel), ("gyro", block.gyro)):
        frames[name] = fits((counts * Z_MINUS_Y_X)[:, ::-1], -INT32, INT32 - 1, f"{name} (as Z, -Y, X)")
    return frames


def encode(block: CountBlock, dtype: np.dtype[np.void], message: int) -> bytes:
    """Return the frames of a block; counter and temperature are not sent, nor health where there is no type."""
    return seal(rows(block, dtype, message), crc)


def identify(frame: bytes, dtype: np.dtype[np.void]) -> Identity:
    """Return the IMU model that the type byte names; the log has no serial number."""
    imu_type = int(np.frombuffer(frame, dtype)["type"][0])
    scale = MODELS.get(imu_type)
    if scale is None:
        return Identity(model=f"NovAtel IMU type {imu_type}")
    return Identity(model=scale.model, period=1 / scale.rate_hz)


def binary_log(name: str, message: int, example: bytes, *, is_long: bool, is_typed: bool) -> WireFormat:
    """Return the wire format of one log, asked for with ``log NAMEb onnew``."""
    dtype = table(is_long=is_long, is_typed=is_typed)
    sync, size = (LONG_SYNC, LONG_HEADER) if is_long else (SHORT_SYNC, BODY_BYTES)
    imu = FrameKind(prefix=sync + bytes((size,)) + message.to_bytes(2, "little"), dtype=dtype)
    sends = partial(encode, dtype=dtype, message=message)
    return WireFormat(
        name=name,
        title=f"NovAtel {name.upper()} {'long' if is_long else 'short'} binary",
        source=f"docs.novatel.com/OEM7, log {name.upper()} (message {message})",
        length_at=LENGTH_AT,
        imu=imu,
        check=CHECK,
        check_bits=32,
        is_intact=is_intact,
        decode=decode,
        encode=sends,
        pulse=gps_seconds(sends, is_long=is_long, is_text=False),
        carries=CARRIES | ({"healthy"} if is_typed else set()),
        baud=BAUD,
        identity=imu if is_typed else None,
        identify=partial(identify, dtype=dtype) if is_typed else None,
        scales=SCALES,
        example=example,
    )


_PAGE = "OEM7 manual, RAWIMUSX, raw IMU scale factors"
# The driver's 1/3.2808 is 12 ppm off the exact foot.
_FOOT27, _FOOT26 = M_PER_FT * 2.0**-27, M_PER_FT * 2.0**-26
# oem7_imu.cpp returns the KVH value in degrees where all others are radians: 57.3 times too large.
_FSAS = (0.1 * 2.0**-8 * RAD_PER_ARCSEC, 0.05 * 2.0**-15)
# Per second: these send rates.
_EPSON320 = (0.008 * 2.0**-16 * RAD_PER_DEG, 0.2e-3 * 2.0**-16 * STANDARD_GRAVITY)
_EPSON370 = (0.0151515 * 2.0**-16 * RAD_PER_DEG, 0.4e-3 * 2.0**-16 * STANDARD_GRAVITY)
_MODELS: tuple[tuple[int, str, float, float, float], ...] = (  # type, model, rad, m/s per count, Hz
    (1, "HG1700 AG11", 2.0**-33, _FOOT27, 100),
    (4, "HG1700 AG17", 2.0**-33, _FOOT26, 100),
    (5, "HG1900 CA29", 2.0**-33, _FOOT27, 100),
    (8, "LN-200", 2.0**-19, 2.0**-14, 200),
    (11, "HG1700 AG58", 2.0**-33, _FOOT27, 100),
    (12, "HG1700 AG62", 2.0**-33, _FOOT26, 100),
    (13, "iMAR FSAS", *_FSAS, 200),
    (16, "KVH COTS", *_FSAS, 200),
    (20, "HG1930 AA99", 2.0**-33, _FOOT27, 100),
    (26, "ISA-100C", 1e-9, 2e-8, 200),  # listed at 100 Hz once: novatel_oem7_driver issue 79
    (27, "HG1900 CA50", 2.0**-33, _FOOT27, 100),
    (28, "HG1930 CA50", 2.0**-33, _FOOT27, 100),
    (31, "ADIS16488", 720 * 2.0**-31 * RAD_PER_DEG, 200 * 2.0**-31, 200),
    (32, "STIM300", 2.0**-21 * RAD_PER_DEG, 2.0**-22, 125),
    (33, "KVH 1750", *_FSAS, 200),
    (41, "Epson EG320N", _EPSON320[0] / 125, _EPSON320[1] / 125, 125),
    (52, "LITEF uIMU-IC", 1e-9, 2e-8, 200),
    (56, "STIM300D", 2.0**-21 * RAD_PER_DEG, 2.0**-22, 125),
    (58, "HG4930 AN01", 2.0**-33, 2.0**-29, 100),
    (61, "Epson EG370N", _EPSON370[0] / 200, _EPSON370[1] / 200, 200),
    (62, "Epson EG320N 200 Hz", _EPSON320[0] / 200, _EPSON320[1] / 200, 200),
    (68, "HG4930 AN04", 2.0**-33, 2.0**-29, 100),
    (69, "HG4930 AN04 400 Hz", 2.0**-33, 2.0**-29, 400),
)
MODELS = {row[0]: NominalScale(*row[1:], source=_PAGE) for row in _MODELS}  # by IMU type
SCALES: Mapping[str, NominalScale] = MappingProxyType({scale.model: scale for scale in MODELS.values()})
