"""A CAN frame as received, in 32 bytes: what a CAN port's byte stream, the raw journal and a replay are made of.

A bus hands over frames, the reader and the journal want bytes. A record has a sync, a length and a CRC of its own,
so that a damaged recording is noticed as one of a serial line is.
"""

import struct
import zlib

import numpy as np

from drivers.wire import FrameKind
from drivers.wire.counts import HEAD
from drivers.wire.counts import is_intact as is_intact

SYNC = b"\xca\x4e"
KIND = 1
STANDARD, WIDE = 0x7FF, 0x1FFFFFFF  # the largest identifiers of 11 and of 29 bits
EXTENDED, REMOTE, ERROR = 0x80000000, 0x40000000, 0x20000000  # flags of an identifier, as SocketCAN has them
NO_DATA_FRAME = REMOTE | ERROR

RECORD = np.dtype(
    [
        *HEAD,
        ("id", "<u4"),  # with the flags
        ("host_ns", "<i8"),  # the station's monotonic clock when the frame was handed over
        ("data", "u1", 8),  # padded with zeros
        ("size", "u1"),  # bytes of payload as received; above 8 the rest is not kept
        ("spare", "u1", 3),
        ("crc", "<u4"),  # CRC-32/ISO-HDLC over everything before it
    ]
)

IMU = FrameKind(prefix=SYNC + bytes((KIND, RECORD.itemsize)), dtype=RECORD)
_BODY = struct.Struct("<4sIq8sB3x")
_CRC = struct.Struct("<I")


def pack(identifier: int, host_ns: int, data: bytes | bytearray) -> bytes:
    """Return the record of one frame; ``identifier`` has its flags in it."""
    body = _BODY.pack(IMU.prefix, identifier, host_ns, data, min(len(data), 255))
    return body + _CRC.pack(zlib.crc32(body))


def pack_all(identifiers: np.ndarray, host_ns: np.ndarray, data: np.ndarray, sizes: np.ndarray) -> bytes:
    """Return the records of frames.

    Parameters
    ----------
    identifiers, sizes
        (n,) identifiers with their flags, and how many bytes of ``data`` are sent.
    host_ns
        (n,) when they were read [ns].
    data
        (n, 8) payloads [bytes], padded with zeros.
    """
    rows = zip(identifiers.tolist(), host_ns.tolist(), data, sizes.tolist(), strict=True)
    return b"".join(pack(each, at, octets.tobytes()[:size]) for each, at, octets, size in rows)


def unpack(data: bytes) -> list[tuple[int, bytes]]:
    """Return identifier and payload of whole records that stand end to end."""
    records = np.frombuffer(data, RECORD)
    rows = zip(records["id"].tolist(), records["data"], records["size"].tolist(), strict=True)
    return [(identifier, octets.tobytes()[:size]) for identifier, octets, size in rows]
