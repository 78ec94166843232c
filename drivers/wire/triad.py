"""Three single-axis gyros read on three ports, as one device: samples joined by time, and the bytes behind them.

The port `drivers.triad_port` writes both kinds of frame, little-endian, into one stream: every byte as it was
read from each axis, and each sample whose three parts came. So what is recorded holds what was joined and from
what. A sample of which a part is missing is left out; the counter goes on, so that the gap shows. Time is the
host's.
"""

import zlib
from functools import partial

import numpy as np

from drivers.host_times import HINDSIGHT_S
from drivers.wire import counts
from drivers.wire.checksums import seal
from drivers.wire.wire_format import FrameKind, WireFormat
from procedures.counts.sample_records import CountBlock

SYNC = b"\x9d\x3a"
FAULTS = 0x0007  # status bits 0, 1, 2: x, y, z not healthy
MAX_READ_BYTES = 18  # bytes of an axis in a frame

SAMPLE = np.dtype(
    [
        *counts.HEAD,
        ("counter", "<u4"),  # one more with every sample of x, joined or not
        ("time_ns", "<i8"),  # of x, on the host's clock
        ("gyro", "<i4", 3),
        ("temperature", "<i2"),  # 0.01 degC, mean of the three
        ("status", "<u2"),
        ("crc", "<u4"),
    ]
)
READ = np.dtype(
    [
        *counts.HEAD,
        ("host_ns", "<i8"),  # when they were read
        ("axis", "u1"),  # 0, 1, 2
        ("size", "u1"),  # of these bytes
        ("data", "u1", MAX_READ_BYTES),
        ("crc", "<u4"),
    ]
)


def encode(block: CountBlock) -> bytes:
    """Return the frames of a block; an unhealthy sample without a fault bit is sent with all three."""
    return counts.encode_as(IMU, block, FAULTS, FAULTS)


def encode_read(host_ns: int, axis: int, data: bytes) -> bytes:
    """Return bytes as they were read from an axis, in as many frames as it takes."""
    pieces = [data[at : at + MAX_READ_BYTES] for at in range(0, len(data), MAX_READ_BYTES)]
    frames = np.zeros(len(pieces), READ)
    frames["sync"] = np.frombuffer(SYNC, np.uint8)
    frames["kind"], frames["length"] = BYTES.prefix[2:4]
    frames["host_ns"], frames["axis"] = host_ns, axis
    frames["size"] = [len(piece) for piece in pieces]
    frames["data"] = [list(piece.ljust(MAX_READ_BYTES, b"\0")) for piece in pieces]
    return seal(frames, zlib.crc32)


IMU = FrameKind(SYNC + bytes((1, SAMPLE.itemsize)), SAMPLE, channels=frozenset({"gx", "gy", "gz"}))
BYTES = FrameKind(SYNC + bytes((2, READ.itemsize)), READ)

FORMAT = WireFormat(
    name="triad",
    title="Three single-axis gyros, joined by the station",
    source="docs/reference/wire-formats.md",
    length_at=3,
    imu=IMU,
    passed_over=(BYTES,),
    check="CRC-32/ISO-HDLC over everything before it",
    check_bits=32,
    is_intact=counts.is_intact,
    decode=partial(counts.decode, fault_bits=FAULTS),
    encode=encode,
    carries=frozenset({"counter", "device_time", "temperature", "status", "healthy"}),
    baud=115200,
    counter_modulus=2**32,
    hindsight_s=HINDSIGHT_S,
    # made by `encode`: sample 7 at 1 s, counts 1, -2, 3, 25 degC
    example=bytes.fromhex("9d3a0124 07000000 00ca9a3b00000000 01000000feffffff03000000 c409 0000 214d176e"),
)
FORMATS = (FORMAT,)
