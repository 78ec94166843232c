"""Faults of what stands beside a simulated IMU, receiver or camera: from a true time on, for some seconds.

A fault file is TOML with one ``[[gnss_fault]]`` or ``[[camera_fault]]`` table each: ``kind``, ``at_s`` (true
time), ``seconds`` and, where the kind has one, ``size``.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from inspect import signature
from typing import Any, TypeVar

from drivers.simulated.errors import TruthRefused

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

    Raises
    ------
    TruthRefused
        If a MAVLink system is to be one that no byte holds.
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
        if unknown := sorted(set(table) - {*accepted}):
            raise TruthRefused(f"{name} key {unknown[0]!r}", ", ".join(accepted))
        if (kind := table.get("kind")) not in (*kinds,):
            raise TruthRefused(f"{name} kind {kind!r}"[:80], ", ".join(kinds))
        for key, value in {"at_s": None, **table}.items():
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if key != "kind" and not (is_number and (is_signed or 0 <= value < 1e9)):
                raise TruthRefused(
                    f"{name} {key} = {value!r}"[:80], f"a number{'' if is_signed else ', not negative'}"
                )
        found.append(record(**table))
    return tuple(found)


gnss_faults_from = partial(read_faults, TimedFault, "gnss_fault", GNSS_KINDS)
camera_faults_from = partial(read_faults, TimedFault, "camera_fault", CAMERA_KINDS)
