"""NovAtel RAWIMUSX, short binary log 1462: raw IMU counts with GPS time, little-endian.

Source: OEM7 manual, log RAWIMUSX (docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMUSX.htm). Asked for with
``log rawimusxb onnew``. Counts are increments per IMU sample in the order Z, minus Y, X. The header's time
is that of the log, the body's that of the sample. Device time is GPS seconds since 1980-01-06, so that it
rises over a change of week. There is no frame counter and no temperature.
"""

import numpy as np

from drivers.wire import novatel
from drivers.wire._format import FrameKind, Frames, Identity, WireFormat, fits, seal
from procedures.records import CountBlock

MESSAGE = 1462
KVH_1750 = 33  # what `encode` says it is: a FOG IMU
ERROR, ENCRYPTED = 0x01, 0x02  # IMU info bits; the rest are reserved

FRAME = np.dtype(
    [
        ("sync", "u1", 3),
        ("length", "u1"),  # of the body
        ("id", "<u2"),
        ("log_week", "<u2"),
        ("log_ms", "<u4"),
        ("info", "u1"),
        ("type", "u1"),
        ("week", "<u2"),
        ("seconds", "<f8"),  # into the week
        ("status", "<u4"),  # its meaning depends on the IMU type
        ("accel", "<i4", 3),  # velocity increments Z, -Y, X
        ("gyro", "<i4", 3),  # angle increments Z, -Y, X
        ("crc", "<u4"),
    ]
)


def decode(frames: Frames) -> CountBlock:
    """Return the counts; unhealthy where the IMU error or encrypted bit is set or the time is no time of week."""
    time = novatel.gps_time(frames["week"].astype(np.int64), frames["seconds"])
    return CountBlock(
        counter=novatel.no_counter(frames),
        device_time=time,
        gyro=novatel.xyz(frames, "gyro"),
        accel=novatel.xyz(frames, "accel"),
        temperature=novatel.unknown_temperature(frames),
        status=frames["status"].astype(np.int64),
        healthy=((frames["info"] & (ERROR | ENCRYPTED)) == 0) & ~np.isnan(time),
    )


def encode(block: CountBlock) -> bytes:
    """Return the frames of a block as a KVH 1750 (type 33) gives them; counter and temperature are not sent."""
    frames = np.zeros(len(block), FRAME)
    week, seconds = novatel.week_and_seconds(block)
    novatel.header(frames, MESSAGE, week, seconds)
    frames["info"] = np.where(block.healthy, 0, ERROR)
    frames["type"], frames["week"], frames["seconds"] = KVH_1750, week, seconds
    frames["status"] = fits(block.status, 0, 2**32 - 1, "status")
    for name, counts in (("accel", block.accel), ("gyro", block.gyro)):
        frames[name] = novatel.z_minus_y_x(counts, name)
    return seal(frames, novatel.crc)


def identify(frame: bytes) -> Identity:
    """Return the IMU model that the type byte names; the log has no serial number."""
    imu_type = frame[13]
    scale = novatel.MODELS.get(imu_type)
    if scale is None:
        return Identity(model=f"NovAtel IMU type {imu_type}")
    return Identity(model=scale.model, period=1 / scale.rate_hz)


IMU = FrameKind(prefix=novatel.SYNC + bytes((40,)) + MESSAGE.to_bytes(2, "little"), dtype=FRAME)

FORMAT = WireFormat(
    name="rawimusx",
    title="NovAtel RAWIMUSX short binary",
    source="docs.novatel.com/OEM7, log RAWIMUSX (message 1462)",
    sync=novatel.SYNC,
    length_at=novatel.LENGTH_AT,
    imu=IMU,
    check=novatel.CHECK,
    check_bits=32,
    is_intact=novatel.is_intact,
    decode=decode,
    encode=encode,
    carries=novatel.CARRIES | {"healthy"},
    baud=novatel.BAUD,
    identity=IMU,
    identify=identify,
    scales=novatel.SCALES,
    # novatel_edie (MIT), python/test/test_decode_encode.py
    example=bytes.fromhex(
        "aa441328b6059c0678b9e21c 000b9c06 0b9755a832941d41 03158000"
        "ebd09102 a687f3ff 38eafcff 66b7fcff 1c5fffff 59d9ffff 475fafba"
    ),
)
