"""Frames cut, misread at another baud rate, or answered by another unit: what a bad line makes of them."""

from dataclasses import replace
from typing import Any

import numpy as np

from drivers.simulated.can_faults import RECORD_BYTES, records_of, text_of_records
from drivers.wire import WireFormat
from procedures.counts.sample_records import SampleBlock

BAUD_RATIO = 2  # as fast as it is sent, the receiver believes
OTHER_UNIT_OFFSET = 7  # counts or units by which the other unit differs, beside the sign


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
