"""The bytes of faulty frames: cut, misread at another baud rate, answered by another unit.

`faults` is the table of all faults, with their times.

On CAN a sample's frames are records end to end, see `drivers.can.frame_record`.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from drivers.can.frame_record import EXTENDED, RECORD, STANDARD, WIDE, pack, unpack
from drivers.wire import WireFormat
from procedures.counts.sample_records import SampleBlock

RECORD_BYTES = RECORD.itemsize
FIRST_FOREIGN_ID = 0x320  # identifiers from here on are another device's
BAUD_RATIO = 2  # as fast as it is sent, the receiver believes
OTHER_UNIT_OFFSET = 7  # counts or units by which the other unit differs, in addition to the sign


def half_of(frame: bytes, wire: WireFormat) -> list[bytes]:
    """Return the first half of a frame; on CAN of a sample's frames, the last one cut on the adapter's line."""
    if wire.joiner is None:
        return [frame[: len(frame) // 2]]
    middle = len(frame) // 2 // RECORD_BYTES * RECORD_BYTES
    return [frame[:middle], text_of_records(frame[middle : middle + RECORD_BYTES])[:-7]]


def misread(frame: bytes, wire: WireFormat) -> bytes:
    """Return what a UART at twice the baud rate takes bytes of 8N1 for; on CAN on the adapter's line.

    It looks at the middle of its own bits: each falling edge begins a byte, and a stop bit that is low is passed
    over, as kernels do.
    """
    text = frame if wire.joiner is None else text_of_records(frame)
    octets = np.frombuffer(text, np.uint8)
    ones = np.ones((len(octets), 1), np.uint8)
    line = np.hstack((0 * ones, np.unpackbits(octets[:, None], axis=1, bitorder="little"), ones)).ravel()
    seen, at, got = np.repeat(line, BAUD_RATIO).tolist() + [1] * 10, 0, bytearray()
    while 0 in seen[at:] and (at := seen.index(0, at)) + 10 <= len(seen):
        got.append(sum(bit << k for k, bit in enumerate(seen[at + 1 : at + 9])))
        at += 10
    return bytes(got)


def mingled(frame: bytes, other: bytes, wire: WireFormat, rng: np.random.Generator) -> list[bytes]:
    """Return two devices' frames of the same moment in any order; on CAN those of a sample between each other."""
    if wire.joiner is None:
        return [frame, other] if rng.integers(2) else [other, frame]
    parts = [records_of(frame), records_of(other)]
    turns = rng.permutation(np.repeat((0, 1), [len(part) for part in parts]))
    return [b"".join(parts[turn].pop(0) for turn in turns)]


def other_unit(block: SampleBlock, ahead: int) -> SampleBlock:
    """Return what another unit says at the same moment; its counter is ``ahead`` by so many."""
    values: Any = {"gyro": OTHER_UNIT_OFFSET - block.gyro, "accel": OTHER_UNIT_OFFSET - block.accel}
    return replace(block, counter=block.counter + ahead, **values)


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
