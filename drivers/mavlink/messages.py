"""The messages read here, unpacked by pymavlink's tables (mavlink/mavlink message_definitions, dialect ``all``).

Nothing else of pymavlink reads bytes: its parser loses the frame after a false start, takes a message that it does
not know without a check, and remembers a time stamp before it has checked the signature.
"""

from typing import Any, NamedTuple

from pymavlink.dialects.v20 import all as dialect  # none has more messages
from pymavlink.generator import mavcrc

HEARTBEAT, SYSTEM_TIME, GPS_RAW_INT, GLOBAL_POSITION_INT, REQUEST_DATA_STREAM = 0, 2, 24, 33, 66
VFR_HUD, COMMAND_LONG, COMMAND_ACK, HIGHRES_IMU, GPS2_RAW, GPS_INPUT = 74, 76, 77, 105, 124, 232

READ = frozenset(
    (
        HEARTBEAT, SYSTEM_TIME, GPS_RAW_INT, GLOBAL_POSITION_INT, VFR_HUD, COMMAND_ACK, HIGHRES_IMU, GPS2_RAW,
        GPS_INPUT,
    )
)  # fmt: skip
KINDS: dict[int, Any] = dialect.mavlink_map
CRC_EXTRA: dict[int, int] = {number: kind.crc_extra for number, kind in KINDS.items()}
_BYTE = [bytes((value,)) for value in range(256)]
NAMES: dict[int, str] = {number: str(kind.msgname) for number, kind in KINDS.items()}


class Frame(NamedTuple):
    """A checked frame: its message's number, who sent it, its place in the sender's sequence, its payload."""

    number: int
    system: int
    component: int
    sequence: int
    payload: bytes


def fields(frame: Frame) -> dict[str, Any]:
    """Return a frame's fields as on the wire; zeros that MAVLink 2 cut off the end are put back."""
    kind = KINDS[frame.number]
    size = kind.unpacker.size
    values = kind.unpacker.unpack(frame.payload[:size].ljust(size, b"\0"))
    return dict(zip(kind.ordered_fieldnames, values, strict=False))


def crc(body: bytes, extra: int) -> int:
    """Return the CRC-16/MCRF4XX of a frame from its length on, with the message's extra byte."""
    whole = body + _BYTE[extra]
    return int(mavcrc.mcrf4xx(whole)) if mavcrc.mcrf4xx else int(mavcrc.x25crc(whole).crc)
