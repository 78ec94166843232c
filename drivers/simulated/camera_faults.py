"""Faults of a simulated camera and of its link; tables ``[[camera_fault]]`` as those of the receiver's."""

from collections.abc import Iterable, Mapping
from typing import Any

from drivers.simulated.timed_faults import TimedFault, timed_faults_from

KINDS = {
    "stall": "nothing is sent, and nothing taken",
    "unplug": "the port is gone",
    "cut": "every image breaks off halfway, then the next part begins",
    "no_stamp": "parts come without X-Timestamp",
    "dark": "images are black",
}


class CameraFault(TimedFault):
    """One fault, see `KINDS`."""

    __slots__ = ()


def camera_faults_from(tables: Iterable[Mapping[str, Any]]) -> tuple[CameraFault, ...]:
    """Return the faults of parsed tables; raise `TruthRefused` naming what is accepted."""
    return timed_faults_from(tables, CameraFault, "camera_fault", KINDS)
