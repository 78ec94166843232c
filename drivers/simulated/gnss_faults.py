"""Faults of a simulated autopilot's GNSS and of its link.

A fault file is TOML with one ``[[gnss_fault]]`` table each: ``kind``, ``at_s`` (true time), ``seconds`` and, where
the kind has one, ``size``.
"""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from drivers.simulated.errors import TruthRefused

KINDS = {
    "no_fix": "the receiver sees too few satellites and loses UTC",
    "jump": "fixes stand `size` m east of the truth",
    "latency": "fixes come `size` s later than they do anyway",
    "time_jump": "UTC is `size` s ahead of the truth",
    "outage": "nothing is sent",
    "unplug": "the port is gone",
    "reboot": "the time since boot begins at 0 again and all intervals are forgotten",
    "wrong_system": "frames come from system `size`",
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


@dataclass(frozen=True, slots=True)
class GnssFault:
    """One fault, from true time ``at_s`` on for ``seconds``; see `KINDS`."""

    kind: str
    at_s: float
    seconds: float = 1.0
    size: float = 0.0


def active(faults: Iterable[GnssFault], now: float, kind: str) -> list[GnssFault]:
    """Return the faults of a kind that act at true time ``now`` [s]."""
    return [fault for fault in faults if fault.kind == kind and fault.at_s <= now < fault.at_s + fault.seconds]


def gnss_faults_from(tables: Iterable[Mapping[str, Any]]) -> tuple[GnssFault, ...]:
    """Return the faults of parsed tables; raise `TruthRefused` naming what is accepted."""
    accepted = {f.name for f in fields(GnssFault)}
    found = []
    for table in tables:
        if unknown := sorted(set(table) - accepted):
            raise TruthRefused(f"gnss_fault key {unknown[0]!r}", ", ".join(sorted(accepted)))
        if table.get("kind") not in KINDS:
            raise TruthRefused(f"gnss_fault kind {table.get('kind')!r}", ", ".join(KINDS))
        for key, value in {"at_s": None, **table}.items():
            if key != "kind" and (isinstance(value, bool) or not isinstance(value, (int, float))):
                raise TruthRefused(f"gnss_fault {key} = {value!r}", "a number")
        found.append(GnssFault(**table))
    return tuple(found)


def load_gnss_faults(text: str) -> tuple[GnssFault, ...]:
    """Return the faults of a TOML text's ``[[gnss_fault]]`` tables."""
    try:
        return gnss_faults_from(tomllib.loads(text).get("gnss_fault", ()))
    except tomllib.TOMLDecodeError as error:
        raise TruthRefused(str(error), "TOML") from error
