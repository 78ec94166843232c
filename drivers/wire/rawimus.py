"""NovAtel RAWIMUS, short binary log 325: RAWIMUSX's older sister, without IMU type and error bit.

Source: OEM7 manual, log RAWIMUS (docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMUS.htm). Time, axis order and
CRC as RAWIMUSX. The meaning of the status word depends on the IMU, which the log does not name: a frame is
read as healthy whenever its time is one, so prefer RAWIMUSX where the receiver has it.
"""

import numpy as np

from drivers.wire import novatel
from drivers.wire._format import FrameKind, Frames, WireFormat, fits, seal
from procedures.records import CountBlock

MESSAGE = 325

FRAME = np.dtype(
    [
        ("sync", "u1", 3),
        ("length", "u1"),  # of the body
        ("id", "<u2"),
        ("log_week", "<u2"),
        ("log_ms", "<u4"),
        ("week", "<u4"),
        ("seconds", "<f8"),  # into the week
        ("status", "<u4"),  # its meaning depends on the IMU
        ("accel", "<i4", 3),  # velocity increments Z, -Y, X
        ("gyro", "<i4", 3),  # angle increments Z, -Y, X
        ("crc", "<u4"),
    ]
)


def decode(frames: Frames) -> CountBlock:
    """Return the counts; unhealthy only where the time is no time of week."""
    time = novatel.gps_time(frames["week"].astype(np.int64), frames["seconds"])
    return CountBlock(
        counter=novatel.no_counter(frames),
        device_time=time,
        gyro=novatel.xyz(frames, "gyro"),
        accel=novatel.xyz(frames, "accel"),
        temperature=novatel.unknown_temperature(frames),
        status=frames["status"].astype(np.int64),
        healthy=~np.isnan(time),
    )


def encode(block: CountBlock) -> bytes:
    """Return the frames of a block; counter, temperature and health are not sent."""
    frames = np.zeros(len(block), FRAME)
    week, seconds = novatel.week_and_seconds(block)
    novatel.header(frames, MESSAGE, week, seconds)
    frames["week"], frames["seconds"] = week, seconds
    frames["status"] = fits(block.status, 0, 2**32 - 1, "status")
    for name, counts in (("accel", block.accel), ("gyro", block.gyro)):
        frames[name] = novatel.z_minus_y_x(counts, name)
    return seal(frames, novatel.crc)


FORMAT = WireFormat(
    name="rawimus",
    title="NovAtel RAWIMUS short binary",
    source="docs.novatel.com/OEM7, log RAWIMUS (message 325)",
    sync=novatel.SYNC,
    length_at=novatel.LENGTH_AT,
    imu=FrameKind(prefix=novatel.SYNC + bytes((40,)) + MESSAGE.to_bytes(2, "little"), dtype=FRAME),
    check=novatel.CHECK,
    check_bits=32,
    is_intact=novatel.is_intact,
    decode=decode,
    encode=encode,
    carries=novatel.CARRIES,
    baud=novatel.BAUD,
    scales=novatel.SCALES,
    # The manual's ASCII example (week 2209) in the binary layout; no public binary frame was found.
    example=bytes.fromhex(
        "aa4413284501a1085e684d1d a1080000 9b92ac0371011e41 00fe5aea"
        "98c7a013 3faad9ff fb4b4300 c9b90400 29430900 9397f0ff 0c2daf3a"
    ),
)
