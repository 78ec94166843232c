"""A step's recorded bytes decoded again: they must give the recorded counts."""

from pathlib import Path

import numpy as np

from drivers.wire import WireFormat
from procedures.arrays import FloatArray, IntArray
from procedures.records import CountBlock
from station.errors import Altered
from station.mcap_files import read_step
from station.reader import Chunk
from station.recorder.stream import SampleStream

_WORD = 0xFFFFFFFF
_ROUNDING_NS = 1


def decoded(wire: WireFormat, chunks: list[Chunk]) -> CountBlock:
    """Return the samples that bytes hold, repeats dropped; counters are unwrapped from the first."""
    data = b"".join(chunk.data for chunk in chunks)
    stream = SampleStream(wire)
    return stream.take(Chunk(0, data)).block


def check_raw_bytes(path: Path, wire: WireFormat) -> int:
    """Decode the raw bytes of a step's file again and return how many samples they give, equal to its counts.

    Raises
    ------
    Altered
        If a count, counter, time, temperature or status differs.
    """
    recorded = read_step(path)
    again = decoded(wire, [Chunk(host_ns, data) for host_ns, data in recorded.raw])
    if recorded.gyro is None or recorded.accel is None or len(again) != len(recorded):
        raise Altered(path, f"{len(recorded)} samples", f"{len(again)} in the raw bytes beside them")
    modulus = wire.counter_modulus or _WORD + 1
    pairs = {
        "gyro": (recorded.gyro, again.gyro),
        "accel": (recorded.accel, again.accel),
        "counter": (recorded.counter % modulus, np.maximum(again.counter, 0) % modulus),
        "device time": (recorded.device_ns, _as_counted(wire, recorded.device_ns, again.device_time)),
        "status": (recorded.status, again.status & _WORD),
        "temperature": (np.nan_to_num(recorded.temperature), np.nan_to_num(again.temperature)),
    }
    for name, (found, expected) in pairs.items():
        if len(rows := np.argwhere(found != expected)):
            row = tuple(int(i) for i in rows[0])
            raise Altered(path, f"{name} {found[row]} in sample {row[0]}", f"{expected[row]} in the raw bytes")
    return len(recorded)


def _as_counted(wire: WireFormat, recorded: IntArray, again: FloatArray) -> IntArray:
    """Return times [ns]; where they are counted from a wrapping counter, from the same beginning as recorded."""
    times = np.rint(again * 1e9).astype(np.int64)
    if wire.joiner is None or not len(times):
        return times
    shifted = times + (recorded[0] - times[0])
    return np.where(np.abs(shifted - recorded) <= _ROUNDING_NS, recorded, shifted)
