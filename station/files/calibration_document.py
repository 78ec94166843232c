"""A `calibration/1` read and checked: what is applied to counts, of at least one triad."""

import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from procedures.frames import TRIADS
from station.errors import DataRefused
from station.files.toml_reading import read_text_file

FORMAT = "calibration/1"
_SHAPES = {"scale_factor": (3,), "misalignment": (3, 3), "bias": (3,)}


def read_calibration(path: Path) -> Mapping[str, Any]:
    """Read a calibration/1; raises `DataRefused` as `checked_calibration`."""
    content = read_text_file(path)
    try:
        document = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataRefused(path, None, f"no JSON ({error})", f"a {FORMAT}") from None
    return checked_calibration(document, str(path))


def checked_calibration(document: Any, where: str) -> Mapping[str, Any]:
    """Return a parsed calibration/1 that came from ``where``, if it is one.

    Raises
    ------
    DataRefused
        If it is of another format, or lacks what is applied: a triad, its numbers, coefficients of an effect.
    """
    found = document.get("format") if isinstance(document, dict) else None
    if not isinstance(document, dict) or found != FORMAT:
        remedy = "store the solution first: `station calibrate` offers it" if found == "solution/1" else "name one"
        raise DataRefused(where, None, f"format {found!r}", repr(FORMAT), remedy)
    triads = [name for name in TRIADS if name in document]
    if not triads:
        raise DataRefused(where, None, "no triad", "an accelerometer or a gyroscope")
    for name in triads:
        for part, shape in _SHAPES.items():
            _check(document[name], f"{name}.{part}", shape, where)
    effects = document.get("effects", [])
    if not isinstance(effects, list):
        raise DataRefused(where, None, f"effects {effects!r}"[:60], "a list of effects")
    for entry in effects:
        _check_effect(entry, where)
    _check_beside(document, where)
    return {"effects": [], "model": "unknown", "serial": "unknown", **document}


def is_of_counts(document: Mapping[str, Any]) -> bool:
    """Say whether a calibration/1 is applied to counts; else to rates, in the unit of a device's own output."""
    triad = next(document[name] for name in TRIADS if name in document)
    return not str(triad["scale_factor"].get("unit", "count")).startswith("output")


def doubts(document: Mapping[str, Any], now: datetime) -> list[str]:
    """Say why a calibration/1 is in doubt at a time: it expired, or is not what it was stored as."""
    until, status = document.get("valid_until"), document.get("status", "calibrated")
    said = [f"it expired on {until[:10]}"] if until is not None and datetime.fromisoformat(until) < now else []
    return said + ([str(document.get("status_reason", "") or status)] if status != "calibrated" else [])


def _check(triad: Any, name: str, shape: tuple[int, ...], where: str) -> None:
    try:
        value = np.array(triad[name.partition(".")[2]]["value"], dtype=np.float64)
    except (KeyError, TypeError, ValueError, OverflowError):
        raise DataRefused(where, None, f"no numbers in {name}", f"{shape} of them") from None
    if value.shape != shape or not np.isfinite(value).all():
        raise DataRefused(where, None, f"{name} of shape {value.shape}", f"{shape} numbers")
    if name.endswith("scale_factor") and not value.all():
        raise DataRefused(where, None, f"a {name} of nought", "another")
    if name.endswith("misalignment") and not np.diag(value).all():
        raise DataRefused(where, None, f"a {name} with nought on its diagonal", "each sensor along its own axis")
    if name.endswith("misalignment") and not abs(np.linalg.det(value)) > 0:
        raise DataRefused(where, None, f"a {name} that is singular", "rows that are nearly square to each other")


def _check_beside(document: Mapping[str, Any], where: str) -> None:
    for key in ("accepted_utc", "valid_until"):
        try:
            if document.get(key) is not None and datetime.fromisoformat(document[key]).tzinfo is None:
                raise ValueError
        except (TypeError, ValueError):
            expected = "a time with its zone, 2026-05-11T12:00:00Z"
            raise DataRefused(where, None, f"{key} {document[key]!r}"[:60], expected) from None
    warmth = document.get("temperature_range_c")
    try:
        if warmth is not None and not np.isfinite(np.array(warmth, np.float64).reshape(2)).all():
            raise ValueError
    except (TypeError, ValueError):
        raise DataRefused(where, None, f"temperature_range_c {warmth!r}"[:60], "two numbers [degC]") from None


def _check_effect(entry: Any, where: str) -> None:
    try:
        name = str(entry["name"])
        {key: float(one["value"]) for key, one in entry["coefficients"].items()}
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        said = entry.get("name", "one") if isinstance(entry, dict) else "one"
        raise DataRefused(where, None, f"no coefficients in effect {said}", "a value each") from None
    if not name:
        raise DataRefused(where, None, "an effect without a name", "its name")
