"""Columns that are called x, y, z alone: which sensor they are of, the file's own name says.

Sensor Logger writes ``Gyroscope.csv``, ``TotalAcceleration.csv`` and ``Accelerometer.csv`` (that one without
gravity) with columns ``time, seconds_elapsed, z, y, x`` in rad/s and m/s2; ulog2csv ``..._sensor_gyro_0.csv`` with
x, y, z. Sources: github.com/tszheichoi/awesome-sensor-logger, docs.px4.io.
"""

import re
from collections.abc import Sequence
from pathlib import Path

from procedures.frames import AXES

_KINDS = {
    "gyro": re.compile(r"gyro(?:scope)?|angular_?(?:rate|velocity)|rotation_?rate", re.IGNORECASE),
    "accel": re.compile(r"accel(?:eration|erometer)?|specific_?force", re.IGNORECASE),
}
_MARK, _UNITS = "seconds_elapsed", {"gyro": "rad/s", "accel": "m/s2"}  # Sensor Logger's column, and its units
_NO_GRAVITY = re.compile(r"Accelerometer|.*(?:lin(?:ear)?|user)_?acc.*", re.IGNORECASE)


def bare_axes(names: Sequence[str], file: Path) -> tuple[str, tuple[str | None, ...], list[str]] | None:
    """Return the triad, ``gyro`` or ``accel``, whose x, y, z bare columns are, their names, and remarks.

    None where a column is missing, or the file's name says no sensor or several.
    """
    by_name = {name.strip().lower(): name for name in names}
    kinds = [kind for kind, words in _KINDS.items() if words.search(file.stem)]
    if len(kinds) != 1 or not all(axis in by_name for axis in AXES):
        return None
    said = [f"{','.join(by_name[axis] for axis in AXES)} are the {kinds[0]} x,y,z, by the name of the file"]
    if kinds[0] == "accel" and _MARK in by_name and _NO_GRAVITY.fullmatch(file.stem):
        said.append("Sensor Logger's Accelerometer has no gravity in it; TotalAcceleration.csv has")
    return kinds[0], tuple(by_name[axis] for axis in AXES), said


def unit_by_logger(
    names: Sequence[str], triad_names: Sequence[str | None], triad: str, guesses: list[str]
) -> str | None:
    """Return the unit of bare columns where the header shows which program wrote them, else None; adds a guess."""
    is_bare = [(name or "").strip().lower() for name in triad_names] == list(AXES)
    if not is_bare or _MARK not in (name.strip().lower() for name in names):
        return None
    guesses.append(f"{triad} in {_UNITS[triad]}, as Sensor Logger writes it")
    return _UNITS[triad]
