"""A CAN frame as received, in 32 bytes: what a CAN port's byte stream, the raw recording and a replay are made of.

Of a J1939 identifier, the PGN names the message; sender and priority stand in the other bits. 29 bits are priority
(3), extended data page and data page, PDU format PF (8), PDU specific PS (8), source address (8). Where PF is
below 240 (PDU1) PS is the destination's address, else (PDU2) it belongs to the PGN. Devices claim their source
address on the bus: a DBC's is an example. Source: SAE J1939-21, 5.2 and 5.3.
"""

import struct
import zlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivers.errors import BadCanFile
from drivers.wire import FrameKind
from drivers.wire.counts import HEAD

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


def unpack(data: bytes) -> list[tuple[int, bytes]]:
    """Return identifier and payload of whole records that stand end to end."""
    records = np.frombuffer(data, RECORD)
    rows = zip(records["id"].tolist(), records["data"], records["size"].tolist(), strict=True)
    return [(identifier, octets.tobytes()[:size]) for identifier, octets, size in rows]


ALL_BITS = 0xFFFFFFFF
FLAGS = EXTENDED | REMOTE | ERROR
PAGES_AND_FORMAT, SPECIFIC, SOURCE = 0x03FF0000, 0xFF00, 0xFF
FIRST_PDU2 = 240
NULL_ADDRESS = 0xFE  # of nobody: a DBC that has it names no sender


def pgn_mask(identifier: int) -> int:
    """Return the bits of an identifier, flags included, that say what a frame holds: all of one of 11 bits."""
    if not identifier & EXTENDED:
        return ALL_BITS
    return FLAGS | PAGES_AND_FORMAT | (SPECIFIC if (identifier >> 16) & 0xFF >= FIRST_PDU2 else 0)


def pgn_of(identifier: int) -> int:
    """Return the parameter group number of an identifier of 29 bits."""
    return (identifier & pgn_mask(identifier) & ~FLAGS) >> 8


class SenderWatch:
    """Holds the frames of what a DBC calls one sender to one source address; two devices are never mixed.

    ``path`` is the file that has to say which is meant, and ``remedy`` how, with the addresses put into it.
    """

    def __init__(self, path: str, remedy: str = "say source_address = {} in it") -> None:
        self._path, self._remedy = path, remedy
        self._sources = dict[int, int]()  # the address that frames came from, by the DBC's

    def look(self, sender: int, identifiers: NDArray[np.uint32]) -> None:
        """Take the 29-bit numbers ``identifiers`` (n,) of a sender's frames.

        Raises `BadCanFile` if they come from two addresses: which is meant the mapping must say.
        """
        addresses = identifiers & SOURCE
        known = self._sources.setdefault(sender, int(addresses[0]))
        if len(other := np.flatnonzero(addresses != known)):
            second = int(identifiers[other[0]])
            both = [f"0x{address:02X}" for address in sorted((known, second & SOURCE))]
            found = f"PGN {pgn_of(second)} from source addresses {' and '.join(both)}, two devices"
            raise BadCanFile(self._path, None, found, f"one; {self._remedy.format(' or '.join(both))}")


@dataclass(frozen=True, slots=True)
class WheelReading:
    """``speed`` [m/s] by a frame that came at ``host_ns`` [ns] and was handed on at ``read_ns`` [ns]."""

    host_ns: int
    speed: float
    device_ns: int | None = None
    read_ns: int = field(default=0, compare=False)

    @property
    def came_ns(self) -> int:
        """The moment [ns] from which it is there."""
        return max(self.host_ns, self.read_ns)
