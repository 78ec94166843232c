"""Channels of a live device that put out one value where their neighbours say that they could not: dead ones."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from drivers.wire import FrameKind
from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.dead_channels import (
    MIN_CONSTANT_SAMPLES,
    MIN_EXPECTED_CHANGES,
    MIN_NOISE_LEVELS,
    MIN_WALK_COUNTS2,
    walk,
)
from procedures.counts.sample_records import CountBlock, SampleBlock
from procedures.error_codes import ErrorCode
from station.errors import DataRefused

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
            self._text = _said(found, self._kept[-1][-1], float(self._same[found].min()) * period) if found else ""
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


def _said(found: Sequence[int], values: FloatArray, seconds: float) -> str:
    """Return in words that channels 0..5 put out ``values`` (6,) for so many seconds, and what to do."""
    said = ", ".join(f"{TRIADS[COLUMNS[i][0]]} {COLUMNS[i][1]} a constant {values[i] + 0.0:.6g}" for i in found)
    return f"{said} for {seconds:.0f} s: dead or not there; what needs it is wrong: check its wiring and supply"
