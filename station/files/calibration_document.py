"""A `calibration/1` read and checked: numbers, units and effects, in the units that the station writes.

It is applied to counts and has at least one triad.
"""

import json
import re
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from reprlib import Repr
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import scale_unit
from procedures.effects import EFFECTS
from procedures.effects.excitation import UNITS_OF_NONLINEAR
from procedures.effects.term.law import MAX_ORDER
from procedures.frames import AXES, TRIADS
from station.errors import DataRefused
from station.files.toml_file import read_text_file

_UNITS = {(effect.name, ""): effect.unit for effect in EFFECTS}
_UNITS |= {(effect.name, law.shape): law.unit for effect in EFFECTS for law in effect.laws if law.shape}
_KEYS = {effect.name: law.coefficients for effect in EFFECTS for law in effect.laws if law.suffixes}
_OF_SENSOR = re.compile(rf"[{''.join(AXES)}](\.[1-{MAX_ORDER}])?")
_EFFECT_WORDS = ("name", "unit", "shape", "definition", "sha256")


def check_effect(entry: Any, where: str) -> None:
    """Raise `DataRefused` for an effect that is none, or whose unit or coefficients are none of its own."""
    if not isinstance(entry, dict):
        raise DataRefused(where, None, f"an effect {shown(entry)}", "its name, unit and coefficients")
    for key in _EFFECT_WORDS:
        if not is_text(entry.get(key, "")):
            raise DataRefused(where, None, f"{key} {shown(entry[key])} of an effect", "text")
    if not (name := entry.get("name", "")):
        raise DataRefused(where, None, "an effect without a name", "its name")
    coefficients = entry.get("coefficients")
    if not isinstance(coefficients, dict) or not all(
        isinstance(one, dict) and "value" in one for one in coefficients.values()
    ):
        raise DataRefused(where, None, f"no coefficients in effect {shown(name)}", "a value each")
    for key, one in coefficients.items():
        number(one["value"], f"{shown(name)[1:-1]} {shown(key)[1:-1]}", where)
        if one.get("std") is not None and number(one["std"], f"{name} {key} std", where) < 0:
            raise DataRefused(
                where, None, f"a std of {name} {key} below zero", "a standard uncertainty of 0 or more"
            )
    if "definition" not in entry:
        _check_of_catalogue(entry, name, where)


def _check_of_catalogue(entry: Mapping[str, Any], name: str, where: str) -> None:
    expected = _UNITS.get((name, entry.get("shape", "")))
    if expected is None:  # it is not corrected, and reported so
        return
    if entry.get("unit", expected) != expected and "relaxation" not in name:
        raise DataRefused(where, None, f"{name} in {shown(entry['unit'])}", repr(expected), "convert it")
    keys = _KEYS.get(name)
    for key in entry["coefficients"]:
        is_one = key in UNITS_OF_NONLINEAR or (key in keys if keys else _OF_SENSOR.fullmatch(key))
        if not is_one:
            named = ", ".join(keys) if keys else f"x, y, z, or x.1 to z.{MAX_ORDER}"
            raise DataRefused(where, None, f"coefficient {shown(key)} of {name}", named)


SHAPES: Mapping[str, tuple[int, ...]] = {"scale_factor": (3,), "misalignment": (3, 3), "bias": (3,)}
LARGEST = 1e30  # of a number and of 1 / k: float holds some 1e8 times more
MIN_ALONG = 0.1  # of a sensor's axis along its own: less is no misalignment, and its inverse no scale
LONGEST = 3.0  # of a row of misalignments, whose length is 1
MIN_VOLUME = 1e-6  # that the axes of a triad span: less is no triad
_BIAS = {"accelerometer": "g", "gyroscope": "deg/h"}
_words = Repr()
_words.maxstring = _words.maxother = 40


def shown(value: Any) -> str:
    """Return a value in a few words, however long or deep it is."""
    return _words.repr(value)[:80]


def is_text(value: Any) -> bool:
    """Return whether a value is text that can be written: JSON may hold halves of characters."""
    return isinstance(value, str) and not any("\ud800" <= letter <= "\udfff" for letter in value)


def check_triads(document: Mapping[str, Any], triads: Sequence[str], where: str) -> None:
    """Raise `DataRefused` for triads whose values, sigmas or units are none that the station writes."""
    for name in triads:
        triad = document[name]
        if not isinstance(triad, dict):
            raise DataRefused(where, None, f"{name} {shown(triad)}", ", ".join(SHAPES))
        for part, shape in SHAPES.items():
            known = triad.get(part)
            if not isinstance(known, dict):
                raise DataRefused(where, None, f"no numbers in {name}.{part}", f"{shape} of them")
            value = _array(known.get("value"), shape, f"{name}.{part}", where)
            if (
                known.get("std") is not None
                and (_array(known["std"], shape, f"{name}.{part}.std", where) < 0).any()
            ):
                raise DataRefused(
                    where, None, f"{name}.{part}.std below zero", "a standard uncertainty of 0 or more"
                )
            _check_unit(known, name, part, where)
            _check_usable(value, f"{name}.{part}", where)
    kinds = {str(document[name]["scale_factor"].get("unit", "count")).startswith("output") for name in triads}
    if len(kinds) > 1:
        units = " and ".join(str(document[name]["scale_factor"].get("unit", "count")) for name in triads)
        raise DataRefused(where, None, f"scale factors in {units}", "both of counts, or both of rates")


def number(value: Any, name: str, where: str) -> float:
    """Return a number that is one; raise `DataRefused` for text, truth, or one beyond what is computed with."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LARGEST:
        raise DataRefused(where, None, f"{name} = {shown(value)}", f"a finite number, below {LARGEST:g}")
    return float(value)


def _array(value: Any, shape: tuple[int, ...], name: str, where: str) -> FloatArray:
    numbers = [number(each, name, where) for each in _flat(value)]
    if _shape(value) != shape:
        raise DataRefused(where, None, f"{name} of shape {_shape(value)}", f"{shape} numbers")
    found: FloatArray = np.array(numbers, np.float64).reshape(shape)
    return found


def _flat(value: Any) -> list[Any]:
    """Return what is in a list, or in lists in a list; what is deeper stays as it is, and is no number."""
    rows = value if isinstance(value, list | tuple) else [value]
    return [each for row in rows for each in (row if isinstance(row, list | tuple) else [row])]


def _shape(value: Any) -> tuple[int, ...]:
    if not isinstance(value, list | tuple):
        return ()
    inner = {_shape(each) for each in value}
    return (len(value), *inner.pop()) if len(inner) == 1 else (len(value), -1)


def _check_unit(known: Mapping[str, Any], triad: str, part: str, where: str) -> None:
    if "unit" not in known:
        return
    scale = (scale_unit(triad, counts=True), scale_unit(triad, counts=False))
    expected = {"scale_factor": scale, "misalignment": ("1",), "bias": (_BIAS[triad],)}[part]
    if known["unit"] not in expected:
        found = f"{triad}.{part} in {shown(known['unit'])}"
        raise DataRefused(where, None, found, " or ".join(map(repr, expected)), "convert it")


def _check_usable(value: FloatArray, name: str, where: str) -> None:
    if name.endswith("scale_factor"):
        if not value.all():
            raise DataRefused(where, None, f"a {name} of zero", "another")
        if not (abs(value) > 1 / LARGEST).all():
            raise DataRefused(where, None, f"1 / {name} above {LARGEST:g}", "a number below it")
    if name.endswith("misalignment"):
        along, length = np.abs(np.diag(value)).min(), np.linalg.norm(value, axis=1).max()
        if along < MIN_ALONG:
            found = f"a {name} with a sensor of {along:.2g} along its own axis"
            raise DataRefused(where, None, found, f"at least {MIN_ALONG:g}")
        if length > LONGEST:
            raise DataRefused(where, None, f"a {name} with a row of length {length:.3g}", "rows of length 1")
        if abs(np.linalg.det(value)) < MIN_VOLUME:
            raise DataRefused(where, None, f"a {name} that is singular", "rows nearly square to each other")


def triads_of(document: Mapping[str, Any]) -> list[str]:
    """Return the names of its triads."""
    return [name for name in TRIADS if name in document]


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
    """Return a parsed calibration/1 that came from ``where``, if it is one; what is null in it is omitted.

    Raise `DataRefused` if it is of another format, or what is applied or stated of it is not there, or is not what
    the station writes: a triad, its numbers and their unit, effects, times, temperatures.
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
    _check_statements(known, where)
    return {"effects": [], "model": "unknown", "serial": "unknown", **known}


def is_of_counts(document: Mapping[str, Any]) -> bool:
    """Return whether a calibration/1 is applied to counts; else to rates, in the unit of a device's own output."""
    triad = next(document[name] for name in TRIADS if name in document)
    return not str(triad["scale_factor"].get("unit", "count")).startswith("output")


def doubts(document: Mapping[str, Any], now: datetime) -> list[str]:
    """Say why a calibration/1 is ambiguous at a time: it expired, or is not what it was stored as."""
    until, status = document.get("valid_until"), document.get("status", "calibrated")
    text = [f"it expired on {until[:10]}"] if until is not None and datetime.fromisoformat(until) < now else []
    return text + ([str(document.get("status_reason", "") or status)] if status != "calibrated" else [])


def _check_statements(document: Mapping[str, Any], where: str) -> None:
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
