"""Faults of a line, planted on the bytes a device sends.

A fault file is TOML with one ``[[fault]]`` table each: ``kind``, ``at_s`` (device time), optionally ``every_s``
(again and again) and ``count`` or ``seconds``.
"""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drivers.simulated import garbled_frames
from drivers.simulated.errors import TruthRefused
from drivers.simulated.timed_faults import read_faults
from drivers.wire import WireFormat
from procedures.counts.sample_records import SampleBlock, block_rows

KINDS = {
    "bad_crc": "`count` frames with one bit flipped",
    "garbage": "`count` random bytes before a frame",
    "lost": "`count` frames never sent",
    "repeated": "a frame sent `count` times more",
    "stall": "nothing sent for `seconds`; samples of that time are lost",
    "unplug": "the port is gone for `seconds`; samples of that time are lost",
    "counter_restart": "the frame counter begins at 0 again",
    "backlog": "nothing sent for `seconds`, then all of it at once",
    "half": "`count` frames break off halfway",
    "noise": "for `seconds` four times as many random bytes instead of frames",
    "wrong_baud": "for `seconds` what a receiver at twice the baud rate reads",
    "two_devices": "for `seconds` another unit sends too, first or second, counter `count` ahead (0: the same)",
    "restart": "nothing for `seconds`, then counter and clock begin at 0 again",
    "clock_jump": "the device's clock goes on `seconds` later",
    "counter_wrap": "the counter goes on `count` frames before its end",
}
CAN_KINDS = {
    "frame_lost": "of a sample, `count` CAN frames never sent",
    "frame_late": "of a sample, a CAN frame sent after the next sample's",
    "babble": "`count` CAN frames of another device before a sample",
    "adapter_hangs": "the adapter neither answers nor forwards for `seconds`",
    "bus_off": "the adapter is bus-off for `seconds` and says so when asked",
}


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault, at device time ``at_s`` and, if ``every_s`` > 0, every so often after it; see `KINDS`."""

    kind: str
    at_s: float
    every_s: float = 0.0
    count: int = 1
    seconds: float = 1.0


@dataclass(frozen=True, slots=True)
class Silence:
    """Send nothing for ``seconds`` of device time, because of a ``kind`` of fault."""

    seconds: float
    kind: str


Sent = bytes | Silence


def faults_from(tables: Iterable[Mapping[str, Any]]) -> tuple[Fault, ...]:
    """Return the faults of parsed ``[[fault]]`` tables; raise `TruthRefused` naming what is accepted."""
    found = read_faults(Fault, "fault", {**KINDS, **CAN_KINDS}, tables, is_signed=False)
    return tuple(replace(fault, count=int(fault.count)) for fault in found)


def load_faults(text: str) -> tuple[Fault, ...]:
    """Return the faults of a TOML text's ``[[fault]]`` tables."""
    try:
        return faults_from(tomllib.loads(text).get("fault", ()))
    except tomllib.TOMLDecodeError as error:
        raise TruthRefused(str(error), "TOML") from error


class FaultyLine:
    """Encodes blocks of one device in order and spoils what the faults say; equal seeds give equal bytes."""

    def __init__(self, wire: WireFormat, faults: Iterable[Fault], period: float, seed: int) -> None:
        self._wire, self._faults, self._period = wire, tuple(faults), period
        self._rng = np.random.default_rng([seed, 0xFA17])
        self._losing = self._spoiling = self._halving = self._holding = 0
        self._restarted, self._clock_off = 0, 0.0  # counter and clock [s] as sent are so much less
        self._lasting: dict[str, tuple[int, Fault]] = {}  # faults of frame after frame: how many to go
        self._held: list[bytes] = []
        self._late = b""
        for fault in self._faults:
            self._check(fault)

    def plant(self, fault: Fault) -> None:
        """Add a fault."""
        self._check(fault)
        self._faults = (*self._faults, fault)

    def _check(self, fault: Fault) -> None:
        accepted = KINDS if self._wire.joiner is None else {**KINDS, **CAN_KINDS}
        if fault.kind not in accepted:
            where = " of a device that is not on CAN" if fault.kind in CAN_KINDS else ""
            raise TruthRefused(f"fault kind {fault.kind!r}{where}", ", ".join(accepted))

    def send(self, block: SampleBlock) -> list[Sent]:
        """Return what goes over the line for a block whose counters are sample numbers since power-on."""
        due = [
            [each for each in self._faults if _acts(each, index, self._period)] for index in block.counter.tolist()
        ]
        ailing = self._losing, self._spoiling, self._halving, self._holding, self._late, self._lasting
        if not any(due) and not any(ailing):
            return [self._wire.encode(self._recounted(block))]
        sent: list[Sent] = []
        for row, faults in enumerate(due):
            sent += self._frame(block, row, faults)
        return sent

    def announce(self, identity: bytes) -> list[Sent]:
        """Return what goes over the line for an identity frame that stands before the next block."""
        if self._losing or not identity or "noise" in self._lasting:
            return []
        return self._unless_held(
            [garbled_frames.misread(identity, self._wire) if "wrong_baud" in self._lasting else identity], 0
        )

    def _recounted(self, block: SampleBlock) -> SampleBlock:
        if not self._restarted and not self._clock_off:
            return block
        counter, time = block.counter - self._restarted, block.device_time - self._clock_off
        return replace(block, counter=counter, device_time=time)

    def _frame(self, block: SampleBlock, row: int, faults: list[Fault]) -> list[Sent]:
        before: list[Sent] = []
        repeats, missing, is_late = 1, 0, False
        for fault in faults:
            match fault.kind:
                case "counter_restart":
                    self._restarted = int(block.counter[row])
                case "garbage":
                    before.append(self._rng.bytes(fault.count))
                case "repeated":
                    repeats += fault.count
                case "bad_crc":
                    self._spoiling += fault.count
                case "lost":
                    self._losing += fault.count
                case "stall" | "unplug" | "adapter_hangs" | "bus_off":
                    before.append(Silence(fault.seconds, fault.kind))
                    self._losing += round(fault.seconds / self._period)
                case "backlog":
                    self._holding += round(fault.seconds / self._period)
                case "restart":
                    before.append(Silence(fault.seconds, fault.kind))
                    self._losing += round(fault.seconds / self._period)
                    self._restarted = int(block.counter[row]) + self._losing
                    self._clock_off = self._restarted * self._period
                case "clock_jump":
                    self._clock_off -= fault.seconds
                case "counter_wrap":
                    self._restarted = int(block.counter[row]) + fault.count - (self._wire.counter_modulus or 0)
                case "half":
                    self._halving += fault.count
                case "noise" | "wrong_baud" | "two_devices":
                    self._lasting[fault.kind] = round(fault.seconds / self._period), fault
                case "frame_lost":
                    missing += fault.count
                case "frame_late":
                    is_late = True
                case "babble":
                    before += [garbled_frames.babble(self._rng) for _ in range(fault.count)]
        if self._losing > 0:
            self._losing -= 1
            return before
        frame = self._wire.encode(self._recounted(block_rows(block, slice(row, row + 1))))
        if self._spoiling > 0:
            self._spoiling -= 1
            frame = self._spoilt(frame)
        frame, self._late = garbled_frames.without(frame, missing, self._rng) + self._late, b""
        if is_late:
            frame, self._late = frame[garbled_frames.RECORD_BYTES :], frame[: garbled_frames.RECORD_BYTES]
        return self._unless_held([*before, *self._garbled(frame * repeats, block, row)])

    def _garbled(self, frame: bytes, block: SampleBlock, row: int) -> list[Sent]:
        """Return what becomes of a frame while it is cut, drowned, misread or answered by another unit."""
        if self._halving:
            self._halving -= 1
            return [*garbled_frames.half_of(frame, self._wire)]
        acting = dict(self._lasting)
        self._lasting = {kind: (left - 1, fault) for kind, (left, fault) in acting.items() if left > 1}
        if "noise" in acting:
            return [self._rng.bytes(4 * len(frame))]
        if "wrong_baud" in acting:
            return [garbled_frames.misread(frame, self._wire)]
        if "two_devices" in acting:
            ahead = acting["two_devices"][1].count
            other = garbled_frames.other_unit(self._recounted(block_rows(block, slice(row, row + 1))), ahead)
            return [*garbled_frames.mingled(frame, self._wire.encode(other), self._wire, self._rng)]
        return [frame]

    def _unless_held(self, sent: list[Sent], frames: int = 1) -> list[Sent]:
        """Hold back what is sent while a backlog builds up; then let go of all of it."""
        if not self._holding:
            return sent
        self._holding -= frames
        self._held += [part for part in sent if isinstance(part, bytes)]
        if self._holding:
            return []
        held, self._held = self._held, []
        return [*held]

    def _spoilt(self, frame: bytes) -> bytes:
        if self._wire.joiner is not None:
            return garbled_frames.spoilt(frame, self._rng)
        # not in the prefix: there it would be a lost sync, not a bad check; nor in what may follow a frame
        at = int(self._rng.integers(len(self._wire.imu.prefix), len(frame.removesuffix(self._wire.trailer))))
        bit = 1 << int(self._rng.integers(8))
        return frame[:at] + bytes([frame[at] ^ bit]) + frame[at + 1 :]


def _acts(fault: Fault, index: int, period: float) -> bool:
    since = index - round(fault.at_s / period)
    every = round(fault.every_s / period)
    return since == 0 or (since > 0 and every > 0 and since % every == 0)
