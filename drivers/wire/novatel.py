"""What the NovAtel SPAN raw IMU logs share: short header, CRC, axis order, GPS time and scale factors.

Sources: OEM7 manual, log pages RAWIMUSX and RAWIMUS, "Description of ASCII and Binary Logs with Short
Headers" and "32-Bit CRC" (docs.novatel.com/OEM7); IMU type ids: novatel_oem7_driver, oem7_imu.hpp.
"""

import zlib
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from drivers.wire._format import Frames, NominalScale, Octets, fits
from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.counts.sample_records import CountBlock
from procedures.units import M_PER_FT, RAD_PER_ARCSEC, RAD_PER_DEG, STANDARD_GRAVITY

SYNC = b"\xaa\x44\x13"
LENGTH_AT = 3  # of the short header: the body's; of the long one: the header's own
CHECK = "CRC-32, reflected polynomial EDB88320, initial 0, no final XOR, over everything before it"
WEEK = 604800  # s
INT32 = 2**31
BAUD = 230400  # 56 bytes x 200 Hz x 10 bits = 112 kbit/s
CARRIES = frozenset({"device_time", "status"})


def crc(data: Octets) -> int:
    """Return NovAtel's CRC-32: zlib's register started at 0 and not inverted at the end."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def is_intact(frame: Octets) -> bool:
    """Say whether a frame passes: the CRC over a message and its own little-endian CRC is 0."""
    return zlib.crc32(frame, 0xFFFFFFFF) == 0xFFFFFFFF


def xyz(frames: Frames, name: str) -> IntArray:
    """Return (n, 3) int64 x, y, z from the wire's Z, -Y, X; in 32 bits -(-2^31) would overflow."""
    counts: IntArray = frames[name][:, ::-1] * np.array([1, -1, 1])
    return counts


def z_minus_y_x(counts: IntArray, name: str) -> IntArray:
    """Return (n, 3) in the wire's order Z, -Y, X; raise ValueError where one does not fit 32 bits."""
    return fits((counts * np.array([1, -1, 1]))[:, ::-1], -INT32, INT32 - 1, f"{name} (as Z, -Y, X)")


def gps_time(week: IntArray, seconds: FloatArray) -> FloatArray:
    """Return seconds since 1980-01-06; nan where the seconds are not within a week.

    Weeks are counted in so that time rises over the change of week; double precision keeps 0.24 us of it.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        time: FloatArray = np.where((seconds >= 0) & (seconds < WEEK), week * float(WEEK) + seconds, np.nan)
    return time


def week_and_seconds(block: CountBlock) -> tuple[IntArray, FloatArray]:
    """Return GPS week and seconds into it; raise ValueError for a time that they cannot hold."""
    if not np.isfinite(block.device_time).all():
        raise ValueError("device_time is not finite; this format sends a time with every frame")
    week = fits(np.floor_divide(block.device_time, WEEK), 0, 2**16 - 1, "GPS week")
    return week, block.device_time - week * float(WEEK)


def no_counter(frames: Frames) -> IntArray:
    """Return -1 for every frame: these logs have no frame counter."""
    return np.full(len(frames), -1, dtype=np.int64)


def unknown_temperature(frames: Frames) -> FloatArray:
    """Return nan for every frame: these logs have no temperature."""
    return np.full(len(frames), np.nan)


def all_good(frames: Frames) -> BoolArray:
    """Return True for every frame."""
    return np.ones(len(frames), dtype=np.bool_)


def _models() -> Mapping[int, NominalScale]:
    page = "OEM7 manual, RAWIMUSX, raw IMU scale factors"
    # The driver's 1/3.2808 is 12 ppm off the exact foot.
    foot27, foot26 = M_PER_FT * 2.0**-27, M_PER_FT * 2.0**-26
    # oem7_imu.cpp returns the KVH value in degrees where all others are radians: 57.3 times too large.
    fsas = (0.1 * 2.0**-8 * RAD_PER_ARCSEC, 0.05 * 2.0**-15)
    # Per second: these send rates.
    epson320 = (0.008 * 2.0**-16 * RAD_PER_DEG, 0.2e-3 * 2.0**-16 * STANDARD_GRAVITY)
    epson370 = (0.0151515 * 2.0**-16 * RAD_PER_DEG, 0.4e-3 * 2.0**-16 * STANDARD_GRAVITY)
    table: tuple[tuple[int, str, float, float, float], ...] = (  # type, model, rad, m/s per count, Hz
        (1, "HG1700 AG11", 2.0**-33, foot27, 100),
        (4, "HG1700 AG17", 2.0**-33, foot26, 100),
        (5, "HG1900 CA29", 2.0**-33, foot27, 100),
        (8, "LN-200", 2.0**-19, 2.0**-14, 200),
        (11, "HG1700 AG58", 2.0**-33, foot27, 100),
        (12, "HG1700 AG62", 2.0**-33, foot26, 100),
        (13, "iMAR FSAS", *fsas, 200),
        (16, "KVH COTS", *fsas, 200),
        (20, "HG1930 AA99", 2.0**-33, foot27, 100),
        (26, "ISA-100C", 1e-9, 2e-8, 200),  # listed at 100 Hz once: novatel_oem7_driver issue 79
        (27, "HG1900 CA50", 2.0**-33, foot27, 100),
        (28, "HG1930 CA50", 2.0**-33, foot27, 100),
        (31, "ADIS16488", 720 * 2.0**-31 * RAD_PER_DEG, 200 * 2.0**-31, 200),
        (32, "STIM300", 2.0**-21 * RAD_PER_DEG, 2.0**-22, 125),
        (33, "KVH 1750", *fsas, 200),
        (41, "Epson EG320N", epson320[0] / 125, epson320[1] / 125, 125),
        (52, "LITEF uIMU-IC", 1e-9, 2e-8, 200),
        (56, "STIM300D", 2.0**-21 * RAD_PER_DEG, 2.0**-22, 125),
        (58, "HG4930 AN01", 2.0**-33, 2.0**-29, 100),
        (61, "Epson EG370N", epson370[0] / 200, epson370[1] / 200, 200),
        (62, "Epson EG320N 200 Hz", epson320[0] / 200, epson320[1] / 200, 200),
        (68, "HG4930 AN04", 2.0**-33, 2.0**-29, 100),
        (69, "HG4930 AN04 400 Hz", 2.0**-33, 2.0**-29, 400),
    )
    return MappingProxyType({row[0]: NominalScale(*row[1:], source=page) for row in table})


MODELS = _models()  # by IMU type
SCALES: Mapping[str, NominalScale] = MappingProxyType({scale.model: scale for scale in MODELS.values()})
