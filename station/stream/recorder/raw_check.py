"""A step's recorded bytes decoded again: they must give the recorded counts."""

from pathlib import Path

import numpy as np

from drivers.wire import WireFormat
from procedures.arrays import IntArray
from procedures.counts.sample_records import SampleBlock
from station.errors import Altered
from station.files.mcap_files import read_step
from station.stream.reader import Chunk
from station.stream.recorder.sample_stream import SampleStream

_WORD = 0xFFFFFFFF
_ROUNDING_NS = 1


def check_raw_bytes(path: Path, wire: WireFormat) -> int:
    """Decode the raw bytes of a step's file again and return how many samples they give, equal to its counts.

    Raises
    ------
    Altered
        If a count, counter, time, temperature or status differs.
    """
    recorded = read_step(path)
    again = SampleStream(wire).take(Chunk(0, b"".join(data for _, data in recorded.raw))).block
    if (recorded.gyro is None and recorded.accel is None) or len(again) != len(recorded):
        raise Altered(path, f"{len(recorded)} samples", f"{len(again)} in the raw bytes beside them")
    triads = {"gyro": (recorded.gyro, again.gyro), "accel": (recorded.accel, again.accel)}
    pairs = {name: pair for name, pair in triads.items() if pair[0] is not None} | {
        "counter": _same_turn(recorded.counter, np.maximum(again.counter, 0) & _WORD, wire.counter_modulus),
        "device time": _times(wire, recorded.device_ns, again),
        "status": (recorded.status, again.status & _WORD),
        "temperature": (np.nan_to_num(recorded.temperature), np.nan_to_num(again.temperature)),
    }
    for name, (found, expected) in pairs.items():
        if len(rows := np.argwhere(found != expected)):
            row = tuple(int(i) for i in rows[0])
            raise Altered(path, f"{name} {found[row]} in sample {row[0]}", f"{expected[row]} in the raw bytes")
    return len(recorded)


def _same_turn(found: IntArray, again: IntArray, modulus: int | None) -> tuple[IntArray, IntArray]:
    """Return two columns without the turns that were counted before the step began."""
    return (found, again) if modulus is None else (found % modulus, again % modulus)


def _times(wire: WireFormat, device_ns: IntArray, again: SampleBlock) -> tuple[IntArray, IntArray]:
    """Return recorded time and time decoded again [ns]; nothing where the host's clock stood in."""
    if "device_time" not in wire.carries:
        return device_ns[:0], device_ns[:0]
    times = np.rint(again.device_time * 1e9).astype(np.int64)
    if wire.joiner is not None and len(times):  # counted from a counter that wraps: from the beginning as recorded
        shifted = times + (device_ns[0] - times[0])
        return device_ns, np.where(np.abs(shifted - device_ns) <= _ROUNDING_NS, device_ns, shifted)
    return _same_turn(device_ns, times, None if wire.time_modulus is None else round(wire.time_modulus * 1e9))
