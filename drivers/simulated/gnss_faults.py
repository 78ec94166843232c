"""Faults of a simulated autopilot's GNSS and of its link.

A fault file is TOML with one ``[[gnss_fault]]`` table each: ``kind``, ``at_s`` (true time), ``seconds`` and, where
the kind has one, ``size``.
"""

import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

from drivers.simulated.errors import TruthRefused
from drivers.simulated.timed_faults import TimedFault, timed_faults_from

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


class GnssFault(TimedFault):
    """One fault, see `KINDS`."""

    __slots__ = ()


def gnss_faults_from(tables: Iterable[Mapping[str, Any]]) -> tuple[GnssFault, ...]:
    """Return the faults of parsed tables; raise `TruthRefused` naming what is accepted."""
    return timed_faults_from(tables, GnssFault, "gnss_fault", KINDS)


def load_gnss_faults(text: str) -> tuple[GnssFault, ...]:
    """Return the faults of a TOML text's ``[[gnss_fault]]`` tables."""
    try:
        return gnss_faults_from(tomllib.loads(text).get("gnss_fault", ()))
    except tomllib.TOMLDecodeError as error:
        raise TruthRefused(str(error), "TOML") from error
