"""Faults of a simulated line, on the bytes a device sends, and of companion devices: the table of every kind.

A fault file is TOML with one ``[[fault]]`` table each (`Fault`), ``[[gnss_fault]]`` of a receiver and
``[[camera_fault]]`` of a camera (`TimedFault`). Errors of the sensors are effects (`drivers.simulated.effects`).
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from inspect import signature
from typing import Any, TypeVar

import numpy as np

from drivers.errors import TruthRefused
from drivers.simulated import corrupted_frames
from drivers.wire import WireFormat
from procedures.counts.sample_records import SampleBlock, block_rows

F = TypeVar("F")
Tables = Iterable[Mapping[str, Any]]
MAX_SYSTEM = 255  # a byte of the frame
GNSS_KINDS = {
    "no_fix": "the receiver sees too few satellites and loses UTC",
    "jump": "fixes stand `size` m east of the truth",
    "latency": "fixes come `size` s later than they do anyway",
    "time_jump": "UTC is `size` s ahead of the truth",
    "outage": "nothing is sent",
    "unplug": "the port is gone",
    "reboot": "the time since boot begins at 0 again and all intervals are forgotten",
    "wrong_system": "frames come from system `size`, 1 to 255; without one from 77",
    "unsigned": "frames of a signing autopilot come without signature",
    "wrong_key": "frames are signed with another key",
    "replay": "every frame is followed by one sent 20 frames before",
    "bad_crc": "every frame has one bit flipped",
    "noise": "random bytes instead of frames",
    "half": "every frame breaks off halfway",
    "repeated": "every frame is sent twice",
    "backlog": "nothing is sent, then all of it at once",
    "deaf": "no command is obeyed or answered",
}
CAMERA_KINDS = {
    "stall": "nothing is sent, and nothing taken",
    "unplug": "the port is gone",
    "cut": "every image breaks off halfway, then the next part begins",
    "no_stamp": "parts come without X-Timestamp",
    "dark": "images are black",
}


@dataclass(frozen=True, slots=True)
class TimedFault:
    """One fault, from true time ``at_s`` on for ``seconds``; see `GNSS_KINDS` and `CAMERA_KINDS`.

    Raises `TruthRefused` if a MAVLink system is to be one that no byte holds.
    """

    kind: str
    at_s: float
    seconds: float = 1.0
    size: float = 0.0

    def __post_init__(self) -> None:
        if self.kind == "wrong_system" and not 0 <= self.size <= MAX_SYSTEM:
            raise TruthRefused(f"wrong_system size = {self.size:g}", f"a MAVLink system, 1 to {MAX_SYSTEM}")


def active(faults: Iterable[TimedFault], now: float, kind: str) -> list[TimedFault]:
    """Return the faults of a kind that act at true time ``now`` [s]."""
    return [fault for fault in faults if fault.kind == kind and fault.at_s <= now < fault.at_s + fault.seconds]


def read_faults(
    record: type[F], name: str, kinds: Mapping[str, str], tables: Tables, is_signed: bool = True
) -> tuple[F, ...]:
    """Return parsed tables called ``name`` as faults; raise `TruthRefused` naming what is accepted.

    Unless ``is_signed`` numbers are from 0 to 1e9.
    """
    accepted = sorted(signature(record).parameters)
    found = []
    for table in tables:
        if unknown := sorted(set(table) - set(accepted)):
            raise TruthRefused(f"{name} key {unknown[0]!r}", ", ".join(accepted))
        if (kind := table.get("kind")) not in (*kinds,):
            raise TruthRefused(f"{name} kind {kind!r}"[:80], ", ".join(kinds))
        for key, value in {"at_s": None, **table}.items():
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if key != "kind" and not (is_number and (is_signed or 0 <= value < 1e9)):
                expected = "a number" if is_signed else "a number, not negative"
                raise TruthRefused(f"{name} {key} = {value!r}"[:80], expected)
        found.append(record(**table))
    return tuple(found)


gnss_faults_from = partial(read_faults, TimedFault, "gnss_fault", GNSS_KINDS)
camera_faults_from = partial(read_faults, TimedFault, "camera_fault", CAMERA_KINDS)


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


class FaultyLine:
    """Encodes blocks of one device in order and spoils what the faults say; equal seeds give equal bytes."""

    def __init__(self, wire: WireFormat, faults: Iterable[Fault], period: float, seed: int) -> None:
        self._wire, self._faults, self._period = wire, tuple(faults), period
        self._rng = np.random.default_rng([seed, 0xFA17])
        self._left = Counter[str]()  # frames to go, by kind of fault
        self._ahead = 0  # of the other unit's counter
        self._restarted, self._clock_off = 0, 0.0  # counter and clock [s] as sent are so much less
        self._held: list[Sent] = []
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
        if not (any(due) or self._left.total() or self._late):
            return [self._wire.encode(self._recounted(block))]
        sent: list[Sent] = []
        for row, faults in enumerate(due):
            sent += self._frame(block, row, faults)
        return sent

    def announce(self, identity: bytes) -> list[Sent]:
        """Return what goes over the line for an identity frame that stands before the next block."""
        if not identity or self._left["lost"] or self._left["noise"]:
            return []
        is_misread = self._left["wrong_baud"] > 0
        return self._unless_held([corrupted_frames.misread(identity, self._wire) if is_misread else identity], 0)

    def _recounted(self, block: SampleBlock) -> SampleBlock:
        if not self._restarted and not self._clock_off:
            return block
        counter, time = block.counter - self._restarted, block.device_time - self._clock_off
        return replace(block, counter=counter, device_time=time)

    def _frame(self, block: SampleBlock, row: int, faults: list[Fault]) -> list[Sent]:
        left, before, once, index = self._left, list[Sent](), Counter[str](), int(block.counter[row])
        for fault in faults:
            frames = round(fault.seconds / self._period)
            match kind := fault.kind:
                case "counter_restart":
                    self._restarted = index
                case "counter_wrap":
                    self._restarted = index + fault.count - (self._wire.counter_modulus or 0)
                case "clock_jump":
                    self._clock_off -= fault.seconds
                case "garbage":
                    before.append(self._rng.bytes(fault.count))
                case "babble":
                    before += [corrupted_frames.babble(self._rng) for _ in range(fault.count)]
                case "repeated" | "frame_lost" | "frame_late":
                    once[kind] += fault.count
                case "bad_crc" | "lost" | "half":
                    left[kind] += fault.count
                case "backlog":
                    left[kind] += frames
                case "noise" | "wrong_baud":
                    left[kind] = frames
                case "two_devices":
                    left[kind], self._ahead = frames, fault.count
                case "stall" | "unplug" | "adapter_hangs" | "bus_off" | "restart":
                    before.append(Silence(fault.seconds, kind))
                    left["lost"] += frames
                    if kind == "restart":
                        self._restarted = index + left["lost"]
                        self._clock_off = self._restarted * self._period
        if self._takes("lost"):
            return before
        frame = self._wire.encode(self._recounted(block_rows(block, slice(row, row + 1))))
        if self._takes("bad_crc"):
            frame = self._spoilt(frame)
        frame, self._late = corrupted_frames.without(frame, once["frame_lost"], self._rng) + self._late, b""
        if "frame_late" in once:
            frame, self._late = frame[corrupted_frames.RECORD_BYTES :], frame[: corrupted_frames.RECORD_BYTES]
        return self._unless_held([*before, *self._garbled(frame * (1 + once["repeated"]), block, row)])

    def _takes(self, kind: str) -> bool:
        """Say whether a fault of frame after frame acts on this one, and count it."""
        acts = self._left[kind] > 0
        self._left[kind] -= acts
        return acts

    def _garbled(self, frame: bytes, block: SampleBlock, row: int) -> list[bytes]:
        """Return what becomes of a frame while it is cut, drowned, misread or answered by another unit."""
        if self._takes("half"):
            return corrupted_frames.half_of(frame, self._wire)
        acting = {kind for kind in ("noise", "wrong_baud", "two_devices") if self._takes(kind)}
        if "noise" in acting:
            return [self._rng.bytes(4 * len(frame))]
        if "wrong_baud" in acting:
            return [corrupted_frames.misread(frame, self._wire)]
        if "two_devices" in acting:
            own = self._recounted(block_rows(block, slice(row, row + 1)))
            other = self._wire.encode(corrupted_frames.other_unit(own, self._ahead))
            return corrupted_frames.mingled(frame, other, self._wire, self._rng)
        return [frame]

    def _unless_held(self, sent: list[Sent], frames: int = 1) -> list[Sent]:
        """Hold back what is sent while a backlog builds up; then let go of all of it."""
        if not self._left["backlog"]:
            return sent
        self._left["backlog"] -= frames
        self._held += [part for part in sent if isinstance(part, bytes)]
        if self._left["backlog"]:
            return []
        held, self._held = self._held, []
        return held

    def _spoilt(self, frame: bytes) -> bytes:
        if self._wire.joiner is not None:
            return corrupted_frames.spoilt(frame, self._rng)
        # not in the prefix: there it would be a lost sync, not a bad check; nor in what may follow a frame
        at = int(self._rng.integers(len(self._wire.imu.prefix), len(frame.removesuffix(self._wire.trailer))))
        bit = 1 << int(self._rng.integers(8))
        return frame[:at] + bytes([frame[at] ^ bit]) + frame[at + 1 :]


def _acts(fault: Fault, index: int, period: float) -> bool:
    since = index - round(fault.at_s / period)
    every = round(fault.every_s / period)
    return since == 0 or (since > 0 and every > 0 and since % every == 0)
