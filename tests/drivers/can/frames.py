"""Samples and their CAN frames, for the tests of this folder."""

import numpy as np
import pytest

from drivers.can.can_format import can_format
from drivers.can.frame_record import RECORD
from procedures.counts.sample_records import CountBlock
from tests.paths import DATA

WIRE = can_format()
DBC = DATA / "captures/dbc"
needs_captures = pytest.mark.skipif(not DBC.is_dir(), reason=f"no captures at {DBC}; set STATION_DATA")
PERIOD = 0.002
RECORD_BYTES = RECORD.itemsize


def samples(n: int, first: int = 0, seed: int = 1) -> CountBlock:
    """Return n samples of 500 Hz; no two alike."""
    rng = np.random.default_rng(seed)
    counter = first + np.arange(n)
    return CountBlock(
        counter=counter,
        device_time=(counter + 1) * PERIOD,
        gyro=rng.integers(-(2**31), 2**31, (n, 3)),
        accel=rng.integers(-300, 300, (n, 3)),
        temperature=np.full(n, 25.31),
        status=np.zeros(n, np.int64),
        healthy=np.ones(n, np.bool_),
    )


def frames_of(block: CountBlock) -> list[bytes]:
    """Return the records of a block one by one, without housekeeping: six per sample."""
    stream = WIRE.encode(block)
    records = [stream[at : at + RECORD_BYTES] for at in range(0, len(stream), RECORD_BYTES)]
    return [each for each in records if int.from_bytes(each[4:8], "little") != 0x1A6]
