"""Scales that a log's own header states: ``tscale,0.001`` above the table of a .gcsv (Gyroflow's IMU log).

Source: docs.gyroflow.xyz, "Gyroflow IMU log": t times tscale is s, gx times gscale rad/s, ax times ascale g.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

_STATED = re.compile(r"\s*(tscale|gscale|ascale|orientation)\s*[,;\t=:]\s*(\S+?)\s*[,;]*\s*", re.IGNORECASE)
_SCALED = {"gscale": (re.compile(r"[gr][xyz]", re.IGNORECASE), "rad/s"),
           "ascale": (re.compile(r"a[xyz]", re.IGNORECASE), "g")}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class StatedScales:
    """Names and factors (columns,) of a table's columns by its header, and seconds of a unit of its time."""

    names: tuple[str, ...]
    factors: FloatArray
    time_s: float | None = None
    notes: tuple[str, ...] = ()


def stated_scales(above: Sequence[str], names: tuple[str, ...]) -> StatedScales:
    """Return what the lines above a table state of its columns ``names``."""
    found = {match[1].lower(): match[2] for line in above if (match := _STATED.fullmatch(line))}
    scales = {key: number for key in ("tscale", *_SCALED) if (number := _positive(found.get(key, "")))}
    factors, named, notes = np.ones(len(names)), list(names), list[str]()
    for key, (columns, unit) in _SCALED.items():
        its = [i for i, name in enumerate(names) if columns.fullmatch(name)]
        if key in scales and its:
            factors[its] = scales[key]
            for i in its:
                named[i] = f"{names[i]} [{unit}]"
            notes.append(
                f"{', '.join(names[i] for i in its)} times {key} {scales[key]:g} of the header are {unit}"
            )
    orientation = found.get("orientation", "")
    if orientation and orientation != "XYZ":
        notes.append(f"orientation {orientation} of the header is not applied: axes are those of the columns")
    return StatedScales(tuple(named), factors, scales.get("tscale"), tuple(notes))


def _positive(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if np.isfinite(number) and number > 0 else None
