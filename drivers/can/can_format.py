"""A CAN device as a `WireFormat`: made at run time of a DBC and a mapping file, the station's own by default.

Its frames are CAN frames as received (`drivers.can.frame_record`); a joiner makes samples of them.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.can import frame_record
from drivers.can.dbc_signals import SignalField, payloads_of
from drivers.can.frame_joiner import CanJoiner
from drivers.can.mapping_file import CHECKS, CanMap, Slot, load_map
from drivers.host_times import HINDSIGHT_S
from drivers.wire import FrameCounters, WireFormat
from drivers.wire.counts import is_intact
from drivers.wire.wire_format import Frames, fits
from procedures.arrays import IntArray
from procedures.counts.sample_records import CountBlock, SampleBlock

OWN_DBC = str(Path(__file__).with_name("fog_counts.dbc"))
OWN_MAP = str(Path(__file__).with_name("fog_counts.toml"))
HOUSEKEEPING_S = 0.5  # how often an encoder sends what does not come with every sample


def can_format(dbc: str = "", mapping: str = "", period: float | None = None) -> WireFormat:
    """Return the format that a DBC and a mapping file describe; without them the station's own counts.

    ``period`` [s] stands before the nominal sample period of the mapping.

    Raises `BadCanFile` if either file breaks a rule.
    """
    can_map = load_map(dbc or OWN_DBC, mapping or OWN_MAP, period)
    has_status = any(slot.status for slot in can_map.slots)
    optional = {"temperature": any(slot.temperature for slot in can_map.slots), "status": has_status}
    optional |= {"counter": can_map.counter is not None, "healthy": has_status}
    return WireFormat(
        name=can_map.name,
        title=f"CAN: {can_map.title}",
        source="docs/how-to/can.md",
        length_at=3,
        imu=replace(frame_record.IMU, channels=can_map.channels),
        check=f"{can_map.check_kind or 'none'} in a frame, CRC-32 over a record",
        check_bits=8 if can_map.check_kind else 0,
        is_intact=is_intact,
        decode=partial(_decode, can_map),
        encode=partial(encode, can_map),
        carries=frozenset({"device_time"} | {name for name, has in optional.items() if has}),
        example=_example(can_map),
        baud=0,
        output="rate" if can_map.output == "rate" else "increments",
        max_step=can_map.max_step,
        counter_modulus=None if can_map.counter is None else 1 << can_map.counter.bits,
        hindsight_s=0.1 if can_map.counter or any(slot.time for slot in can_map.slots) else HINDSIGHT_S,
        joiner=partial(CanJoiner, can_map),
    )


def _decode(can_map: CanMap, frames: Frames) -> SampleBlock:
    at = frame_record.RECORD.itemsize * np.arange(len(frames))
    return CanJoiner(can_map, FrameCounters()).take(frames, at)[0]


def _example(can_map: CanMap) -> bytes:
    if can_map.output != "increments":
        return b""
    counts, one = np.array([[1, -2, 3]]), np.ones(1, np.int64)
    block = CountBlock(one, np.array([0.5]), counts, -counts, np.array([25.0]), 0 * one, one == 1)
    return encode(can_map, block)


def encode(can_map: CanMap, block: SampleBlock) -> bytes:
    """Return the records of a block's frames, handed over at device time; counters and times wrap.

    Raises `ValueError` if a count does not fit its signal, or the mapping speaks of running totals, which a block
    does not hold.
    """
    if can_map.output == "cumulative":
        raise ValueError(f"{can_map.name} sends running totals, expected increments to encode")
    every = max(1, round(HOUSEKEEPING_S / can_map.period))
    payloads, places = list[NDArray[np.uint8]](), list[IntArray]()
    for i, slot in enumerate(can_map.slots):
        rows = np.arange(len(block)) if slot.is_needed else np.flatnonzero(block.counter % every == 0)
        order = i if slot.is_needed else i - len(can_map.slots)  # what comes now and then goes before
        payloads.append(_payloads(can_map, slot, block, rows))
        places.append(np.stack((rows, np.full(len(rows), order), np.full(len(rows), i)), axis=1))
    place = np.concatenate(places)
    by_time = np.lexsort((place[:, 1], place[:, 0]))
    ids, sizes = (np.array([getattr(slot, name) for slot in can_map.slots]) for name in ("identifier", "size"))
    row, slots = place[by_time, 0], place[by_time, 2]
    host = np.rint(block.device_time[row] * 1e9).astype(np.int64)
    octets = np.concatenate(payloads)[by_time]
    sent = zip(ids[slots].tolist(), host.tolist(), octets, sizes[slots].tolist(), strict=True)
    return b"".join(frame_record.pack(each, at, data.tobytes()[:size]) for each, at, data, size in sent)


def _payloads(can_map: CanMap, slot: Slot, block: SampleBlock, rows: IntArray) -> NDArray[np.uint8]:
    words = np.zeros(len(rows), np.uint64), np.zeros(len(rows), np.uint64)
    counts = np.hstack((block.gyro, block.accel))[rows]
    for channel, field in slot.channels:
        values = counts[:, channel]
        if can_map.output == "rate":
            values = np.rint((values - field.offset) / field.scale)
        half = 1 << (field.bits - 1)
        low, high = (-half, half - 1) if field.is_signed else (0, 2 * half - 1)
        field.put(words, fits(values, low, high, f"channel {channel}"))
    ticks = np.rint(block.device_time / can_map.time_unit).astype(np.int64)
    for value, unwrapped in ((slot.counter, block.counter), (slot.time, ticks)):
        if value is not None:
            value.put(words, unwrapped[rows])
    if slot.status is not None:
        slot.status.put(words, _status(can_map, slot.status, block)[rows])
    if (warmth := slot.temperature) is not None and not warmth.is_float:
        known = np.nan_to_num(block.temperature[rows])
        warmth.put(words, np.rint((known - warmth.offset) / warmth.scale).astype(np.int64))
    octets = payloads_of(words)
    if slot.check is not None:
        byte = slot.check.shift // 8 if not slot.check.is_big_endian else 7 - slot.check.shift // 8
        rest = np.delete(octets[:, : slot.size], byte, axis=1)
        octets[:, byte] = CHECKS[can_map.check_kind](np.full(len(rows), slot.identifier, np.uint32), rest)
    return octets


def _status(can_map: CanMap, field: SignalField, block: SampleBlock) -> IntArray:
    mask = (1 << field.bits) - 1
    faults = can_map.fault_bits & mask
    good: IntArray = (block.status & mask) | np.where(block.healthy, can_map.good_bits & mask, 0)
    silent = ~block.healthy & ((good & faults) == 0)
    return good | np.where(silent, 1 << max(faults.bit_length() - 1, 0) if faults else 0, 0)
