"""The whole seconds of GPS time in a NovAtel log: as good as a pulse (PPS), for the receiver stamps samples by it.

GPS time is UTC and a whole number of leap seconds, so that both have their seconds at the same moments. A receiver
that does not know the time yet counts from week 0; a long header says how good the time is. Sources: OEM7 manual,
"GPS Reference Time Status" (160 FINE, 170 FINEBACKUPSTEERING, 180 FINESTEERING, 200 SATTIME) and "Description of
ASCII and Binary Logs with Short Headers", which have none.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drivers.wire._format import PulseForm
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock

WEEK = 604800.0  # s
LONG_SYNC = b"\xaa\x44\x12"
STATUS_AT = 13  # of the long binary header
FINE = 160
STATUS_FIELD = 4  # of the long header's text, by commas
FINE_WORDS = ([b"FINE"], [b"FINEBACKUPSTEERING"], [b"FINESTEERING"], [b"SATTIME"])
SIMULATED_WEEK = 2400


def gps_seconds(encode: Callable[[CountBlock], bytes], *, is_long: bool, is_text: bool) -> PulseForm:
    """Return how a log, sent by ``encode``, tells of whole seconds."""
    is_fine = (_says_fine if is_text else _is_fine) if is_long else (lambda data: True)

    def age(data: bytes, sample_s: float) -> float | None:
        return sample_s % 1.0 if sample_s >= WEEK and is_fine(data) else None

    def mark(block: CountBlock, ages: FloatArray) -> bytes:
        whole = np.rint(block.device_time - ages)
        return encode(replace(block, device_time=SIMULATED_WEEK * WEEK + whole + ages))

    return PulseForm(age, mark)


def _is_fine(data: bytes) -> bool:
    at = data.rfind(LONG_SYNC, 0, max(len(data) - STATUS_AT, 0)) + STATUS_AT
    return at >= STATUS_AT and data[at] >= FINE


def _says_fine(data: bytes) -> bool:
    line = data.rpartition(b"*")[0].rpartition(b"#")[2]  # the last whole one
    return line.split(b",", STATUS_FIELD + 1)[STATUS_FIELD : STATUS_FIELD + 1] in FINE_WORDS
