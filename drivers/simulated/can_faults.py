"""What goes wrong on a CAN bus, done to a sample's frames: records end to end, see `drivers.can.frame_record`."""

import numpy as np

from drivers.can.frame_record import EXTENDED, RECORD, STANDARD, WIDE, pack, unpack

RECORD_BYTES = RECORD.itemsize
FIRST_FOREIGN_ID = 0x320  # identifiers from here on are another device's


def babble(rng: np.random.Generator) -> bytes:
    """Return a frame of another device."""
    return pack(FIRST_FOREIGN_ID + int(rng.integers(64)), 0, rng.bytes(int(rng.integers(9))))


def records_of(frames: bytes) -> list[bytes]:
    """Return a sample's frames one by one."""
    return [frames[at : at + RECORD_BYTES] for at in range(0, len(frames), RECORD_BYTES)]


def without(frames: bytes, count: int, rng: np.random.Generator) -> bytes:
    """Return a sample's frames without ``count`` of them."""
    records = records_of(frames)
    for _ in range(min(count, len(records))):
        del records[int(rng.integers(len(records)))]
    return b"".join(records)


def spoilt(frames: bytes, rng: np.random.Generator) -> bytes:
    """Return a sample's frames with one bit of one payload flipped."""
    at = RECORD_BYTES * int(rng.integers(len(frames) // RECORD_BYTES))
    [(identifier, data)] = unpack(frames[at : at + RECORD_BYTES])
    octet, bit = int(rng.integers(len(data))), 1 << int(rng.integers(8))
    data = data[:octet] + bytes([data[octet] ^ bit]) + data[octet + 1 :]
    return frames[:at] + pack(identifier, 0, data) + frames[at + RECORD_BYTES :]


def text_of(identifier: int, data: bytes) -> bytes:
    """Return a received frame as an slcan adapter writes it."""
    if identifier & EXTENDED:
        return b"T%08X%d%s\r" % (identifier & WIDE, len(data), data.hex().upper().encode())
    return b"t%03X%d%s\r" % (identifier & STANDARD, len(data), data.hex().upper().encode())


def text_of_records(records: bytes) -> bytes:
    """Return frames as an slcan adapter writes them."""
    return b"".join(text_of(*frame) for frame in unpack(records))
