"""What is wrong with a stream: counters of the last two seconds, silent channels, a device switched off and on."""

import re
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import fields
from datetime import datetime

import numpy as np

from drivers.wire import FrameKind, WireFormat
from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.dead_channels import (
    MIN_CONSTANT_SAMPLES,
    MIN_EXPECTED_CHANGES,
    MIN_NOISE_LEVELS,
    MIN_WALK_COUNTS2,
    walk,
)
from procedures.counts.sample_records import CountBlock, SampleBlock
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.stream.recorder.sample_stream import DecodedChunk, SampleStream

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
        return _lost_text({name: count - before[name] for name, count in counts.items()})


def _lost_text(new: dict[str, int]) -> str:
    breaks = min(new["samples"], new["breaks"] + new["restarts"])
    if new["samples"] >= MIN_SAMPLES and breaks > MAX_BREAK_SHARE * new["samples"]:
        return f"samples do not follow each other: {breaks} breaks in {new['samples']} samples; {ALONE}"
    if new["incomplete"] >= MIN_SAMPLES and new["incomplete"] > new["samples"]:
        return f"{new['incomplete']} samples miss frames, {new['samples']} are whole; {ALONE}"
    found = [(f"{words}: {new[name]}", remedy) for name, words, remedy in AMISS if new[name]]
    if not found:
        return ""
    return f"within {WITHIN_S:g} s {', '.join(words for words, _ in found[:3])}; {found[0][1]}"


NUMBER = re.compile(r"\d[\d.]*")


class TroubleLog:
    """One stream's troubles, each reported once: other counts in the same words are no other trouble."""

    def __init__(self, name: str, say: Callable[[str], None]) -> None:
        self._name, self._say = name, say
        self._words = ""

    def look(self, trouble: str) -> None:
        """Take what is wrong now, empty where nothing is."""
        if (words := without_numbers(trouble)) != self._words:
            self._words = words
            text = trouble if self._name in trouble else f"{self._name}: {trouble or 'well again'}"
            self._say(f"{datetime.now():%H:%M:%S}  {text}")


def without_numbers(text: str) -> str:
    """Return a text without its numbers."""
    return NUMBER.sub("", text)


COLUMNS = ("gx", "gy", "gz", "ax", "ay", "az")
TRIADS = {"g": "gyroscope", "a": "accelerometer"}
SILENT_AFTER_S = 10.0  # without a change, after which it is looked at
NEIGHBOUR_SAMPLES = 2000  # samples, by which the neighbours are judged


class SilentChannels:
    """Watches samples in order; `text` names the channels that are dead or not there.

    A healthy channel that counts slowly is silent for a while too. So a channel is named only where the noise of
    each live one of its triad would have made it change, or where its whole triad is silent.
    """

    def __init__(self) -> None:
        self._kept: deque[FloatArray] = deque()
        self._same = np.zeros(6, dtype=np.int64)  # samples since the last change
        self._counts = True
        self._judged, self._text = np.zeros(6, dtype=np.int64), ""

    def take(self, block: SampleBlock) -> None:
        """Take the next samples."""
        if not len(block):
            return
        values = np.hstack((block.gyro, block.accel)).astype(np.float64)
        before = self._kept[-1][-1:] if self._kept else values[:1]
        changed = np.diff(values, axis=0, prepend=before) != 0
        since = np.argmax(changed[::-1], axis=0) + 1
        self._same = np.where(changed.any(axis=0), since, len(values) + self._same)
        self._counts = isinstance(block, CountBlock)
        self._kept.append(values)
        while sum(map(len, self._kept)) - len(self._kept[0]) >= NEIGHBOUR_SAMPLES:
            self._kept.popleft()

    def text(self, period: float, channels: frozenset[str], after_s: float = SILENT_AFTER_S) -> str:
        """Return what is wrong with ``channels``, those measured, empty if nothing; ``period`` [s]."""
        silent = (self._same >= max(after_s / period, MIN_CONSTANT_SAMPLES)) & [
            name in channels for name in COLUMNS
        ]
        if not silent.any():
            self._judged, self._text = self._same, ""
        elif np.any(silent & (self._same > 1.1 * self._judged)) or not self._text:  # seldom: it takes a while
            self._judged = self._same
            found = [i for i in np.flatnonzero(silent).tolist() if self._is_dead(i, silent, channels)]
            self._text = (
                _silent_text(found, self._kept[-1][-1], float(self._same[found].min()) * period) if found else ""
            )
        return self._text

    def _is_dead(self, i: int, silent: BoolArray, channels: frozenset[str]) -> bool:
        triad = [j for j in range(6) if j // 3 == i // 3 and COLUMNS[j] in channels]
        live = [j for j in triad if not silent[j]]
        if not live:
            return len(triad) > 1
        window = np.concatenate(self._kept)[-int(self._same[i]) :]  # what moved them before says nothing
        return min(self._surprise(window[:, j], int(self._same[i])) for j in live) > 1

    def _surprise(self, values: FloatArray, same: int) -> float:
        """Return how much more than enough a neighbour's noise is to change a channel within ``same`` samples."""
        if len(values) <= MIN_CONSTANT_SAMPLES:
            return 0.0
        if self._counts:
            return walk(values) * same / MIN_WALK_COUNTS2
        often = np.count_nonzero(np.diff(values)) / (len(values) - 1)
        return float(often * same / MIN_EXPECTED_CHANGES) if len(np.unique(values)) >= MIN_NOISE_LEVELS else 0.0


def refuse_partial(name: str, kind: FrameKind) -> None:
    """Raise `DataRefused` for a device that does not measure six channels, as attitude and place need."""
    if lacking := [channel for channel in COLUMNS if channel not in kind.channels]:
        there = ", ".join(channel for channel in COLUMNS if channel in kind.channels)
        raise DataRefused(
            name, None, f"a device that measures {there} and not {', '.join(lacking)}",
            "three gyroscopes and three accelerometers", "`station record` and `station diagnose` take it",
            ErrorCode.CHANNELS,
        )  # fmt: skip


def _silent_text(found: Sequence[int], values: FloatArray, seconds: float) -> str:
    """Return in words that channels 0..5 put out ``values`` (6,) for so many seconds, and what to do."""
    text = ", ".join(f"{TRIADS[COLUMNS[i][0]]} {COLUMNS[i][1]} a constant {values[i] + 0.0:.6g}" for i in found)
    return f"{text} for {seconds:.0f} s: dead or not there; what needs it is wrong: check its wiring and supply"


MIN_TURN_S = 60.0
ALLOWED_OFFSET_S, ALLOWED_DRIFT = 5.0, 0.02  # of what two clocks are read apart, and drift by in between


def switched_on_again(before_s: float, now_s: float, elapsed_s: float) -> bool:
    """Return whether a clock that does not turn began again in ``elapsed_s`` of the station's time."""
    went, allowed = now_s - before_s, ALLOWED_OFFSET_S + ALLOWED_DRIFT * elapsed_s
    if went < 0:
        return True
    is_short = went < elapsed_s - allowed and went > ALLOWED_OFFSET_S
    return is_short and now_s <= elapsed_s + allowed


def switched_on_again_within(before_s: float, now_s: float, elapsed_s: float, turn_s: float) -> bool:
    """Say the same of a clock that begins again every ``turn_s`` as well."""
    allowed = ALLOWED_OFFSET_S + ALLOWED_DRIFT * elapsed_s
    late = (now_s - before_s - elapsed_s) % turn_s
    if turn_s < MIN_TURN_S or min(late, turn_s - late) <= allowed:
        return False
    return now_s % turn_s <= elapsed_s + allowed


class PowerWatch:
    """Follows a stream and reports where its device was switched on again."""

    def __init__(self, wire: WireFormat) -> None:
        self._wire = wire
        self._last: tuple[float, int, int] | None = None  # time [s], counter, station's time [ns]

    def take(self, piece: DecodedChunk, period: float | None, *, has_time: bool) -> bool:
        """Look at a piece of the stream, ``period`` [s] a sample; return whether the device began again in it."""
        block = piece.block
        if not len(block):
            return False
        began_again = False
        if piece.restart_at is not None and self._last is not None and period:
            row = piece.restart_at
            before = self._last
            if row:
                before = float(block.device_time[row - 1]), int(block.counter[row - 1]), piece.chunk.host_ns
            now = float(block.device_time[row]), int(block.counter[row]), piece.chunk.host_ns
            began_again = self._began_again(before, now, period, has_time=has_time)
        self._last = float(block.device_time[-1]), int(block.counter[-1]), piece.chunk.host_ns
        return began_again

    def _began_again(
        self, before: tuple[float, int, int], now: tuple[float, int, int], period: float, *, has_time: bool
    ) -> bool:
        elapsed, turn = (now[2] - before[2]) / 1e9, self._wire.time_modulus
        frames = self._wire.counter_modulus
        by_counter = frames is not None and switched_on_again_within(
            before[1] * period, now[1] * period, elapsed, frames * period
        )
        if not has_time:
            return by_counter
        if turn is not None:
            return switched_on_again_within(before[0], now[0], elapsed, turn)
        is_distinct = frames is not None and frames * period > MIN_TURN_S
        goes_on = is_distinct and not by_counter  # a clock that was set: the frames continue counting
        return switched_on_again(before[0], now[0], elapsed) and not goes_on
