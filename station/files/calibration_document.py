"""A `calibration/1` read and checked: what is applied to counts, of at least one triad."""

import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from procedures.frames import TRIADS
from station.errors import DataRefused
from station.files.calibration_effects import check_effect
from station.files.calibration_numbers import check_triads, is_text, number, shown, triads_of
from station.files.toml_reading import read_text_file

FORMAT = "calibration/1"
MAX_BYTES = 1 << 24
_WORDS = ("model", "serial", "software", "status", "status_reason", "previous")
_MOMENTS = ("accepted_utc", "valid_from", "valid_until")


def read_calibration(path: Path) -> Mapping[str, Any]:
    """Read a calibration/1; raises `DataRefused` as `checked_calibration`."""
    return parsed_calibration(read_text_file(path, MAX_BYTES), str(path))


def parsed_calibration(content: bytes | str, where: str) -> Mapping[str, Any]:
    """Return the calibration/1 in a text of JSON that came from ``where``; raises as `checked_calibration`."""
    try:
        document = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataRefused(where, None, f"no JSON ({error})", f"a {FORMAT}") from None
    return checked_calibration(document, where)


def checked_calibration(document: Any, where: str) -> Mapping[str, Any]:
    """Return a parsed calibration/1 that came from ``where``, if it is one; what is null in it is left out.

    Raises
    ------
    DataRefused
        If it is of another format, or what is applied or said of it is not there, or is not what the station
        writes: a triad, its numbers and their unit, effects, times, temperatures.
    """
    found = document.get("format") if isinstance(document, dict) else None
    if not isinstance(document, dict) or found != FORMAT:
        remedy = "store the solution first: `station calibrate` offers it" if found == "solution/1" else "name one"
        raise DataRefused(where, None, f"format {shown(found)}", repr(FORMAT), remedy)
    if not isinstance(effects := document.get("effects", []), list):
        raise DataRefused(where, None, f"effects {shown(effects)}", "a list of effects")
    known = {key: value for key, value in document.items() if value is not None}
    if not (triads := triads_of(known)):
        raise DataRefused(where, None, "no triad", "an accelerometer or a gyroscope")
    check_triads(known, triads, where)
    for entry in effects:
        check_effect(entry, where)
    _check_beside(known, where)
    return {"effects": [], "model": "unknown", "serial": "unknown", **known}


def is_of_counts(document: Mapping[str, Any]) -> bool:
    """Say whether a calibration/1 is applied to counts; else to rates, in the unit of a device's own output."""
    triad = next(document[name] for name in TRIADS if name in document)
    return not str(triad["scale_factor"].get("unit", "count")).startswith("output")


def doubts(document: Mapping[str, Any], now: datetime) -> list[str]:
    """Say why a calibration/1 is in doubt at a time: it expired, or is not what it was stored as."""
    until, status = document.get("valid_until"), document.get("status", "calibrated")
    said = [f"it expired on {until[:10]}"] if until is not None and datetime.fromisoformat(until) < now else []
    return said + ([str(document.get("status_reason", "") or status)] if status != "calibrated" else [])


def _check_beside(document: Mapping[str, Any], where: str) -> None:
    for key in _WORDS:
        if not is_text(document.get(key, "")):
            raise DataRefused(where, None, f"{key} {shown(document[key])}", "text")
    for key in _MOMENTS:
        try:
            if key in document and datetime.fromisoformat(document[key]).tzinfo is None:
                raise ValueError
        except (TypeError, ValueError):
            expected = "a time with its zone, 2026-05-11T12:00:00Z"
            raise DataRefused(where, None, f"{key} {shown(document[key])}", expected) from None
    warmth = document.get("temperature_range_c", [0.0, 0.0])
    if not isinstance(warmth, list | tuple) or len(warmth) != 2:
        raise DataRefused(where, None, f"temperature_range_c {shown(warmth)}", "two numbers [degC]")
    low, high = (number(each, "temperature_range_c", where) for each in warmth)
    if low > high:
        raise DataRefused(where, None, f"temperature_range_c from {low:g} to {high:g}", "the lower one first")
