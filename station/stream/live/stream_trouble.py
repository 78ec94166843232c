"""What is amiss with a stream that goes on: what its counters met in the last two seconds, in a line."""

import time
from collections import deque
from collections.abc import Callable
from dataclasses import fields

from station.stream.recorder.sample_stream import SampleStream

WITHIN_S = 2.0
MAX_BREAK_SHARE = 0.2  # of the samples: so many breaks are no accident
MIN_SAMPLES = 5  # samples, to say so

LINE = "check cable, shield and baud rate"
ALONE = "check that one device alone sends there"
LOAD = "check baud rate, adapter and the load of this machine"
DEVICE = "check its power and its sync line"
# What is counted, what it is called, what to do; what weighs most stands first.
AMISS = (
    ("contradicted", "samples that came twice and differ", ALONE),
    ("clock_jumps", "jumps of the device's clock", DEVICE),
    ("restarts", "new beginnings of the device's counter or clock", DEVICE),
    ("bad_crc", "frames with a wrong check", LINE),
    ("bad_length", "frames of a wrong length", LINE),
    ("bus_errors", "bus errors or garbled lines", "check bit rate, tty_baudrate and termination"),
    ("skipped_bytes", "bytes in no frame", LINE),
    ("incomplete", "samples that miss frames", LOAD),
    ("lost", "samples lost", LOAD),
    ("breaks", "breaks", LOAD),
    ("repeated", "samples that came twice", ALONE),
    ("late", "frames late or twice", ALONE),
    ("bad_status", "samples that the device itself doubts", "see what its status says"),
)


class StreamTrouble:
    """Watches one stream's counters."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._seen: deque[tuple[float, dict[str, int]]] = deque()

    def look(self, stream: SampleStream) -> str:
        """Take the counters as they are now, and return what is amiss, empty where nothing is."""
        now, both = self._clock(), (stream.decoder.counters, stream.counters)
        counts = {each.name: getattr(counters, each.name) for counters in both for each in fields(counters)}
        if not counts["samples"]:  # noise before the first frame is the beginning of one
            return ""
        self._seen.append((now, counts))
        while len(self._seen) > 1 and self._seen[1][0] <= now - WITHIN_S:
            self._seen.popleft()
        before = self._seen[0][1]
        return _said({name: count - before[name] for name, count in counts.items()})


def _said(new: dict[str, int]) -> str:
    breaks = min(new["samples"], new["breaks"] + new["restarts"])
    if new["samples"] >= MIN_SAMPLES and breaks > MAX_BREAK_SHARE * new["samples"]:
        return f"samples do not follow each other: {breaks} breaks in {new['samples']} samples; {ALONE}"
    if new["incomplete"] >= MIN_SAMPLES and new["incomplete"] > new["samples"]:
        return f"{new['incomplete']} samples miss frames, {new['samples']} are whole; {ALONE}"
    found = [(f"{words}: {new[name]}", remedy) for name, words, remedy in AMISS if new[name]]
    if not found:
        return ""
    return f"within {WITHIN_S:g} s {', '.join(words for words, _ in found[:3])}; {found[0][1]}"
