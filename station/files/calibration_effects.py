"""The effects of a `calibration/1`: coefficients with the names and in the unit that the station writes."""

import re
from collections.abc import Mapping
from typing import Any

from procedures.effects import EFFECTS
from procedures.effects.cross_product import KEYS as CROSS
from procedures.effects.effect import MATRIX, UNITS_OF_NONLINEAR
from procedures.effects.temperature_polynomial import MAX_ORDER
from procedures.frames import AXES
from station.errors import DataRefused
from station.files.calibration_numbers import is_text, number, shown

_UNITS = {(effect.name, ""): effect.unit for effect in EFFECTS}
_UNITS |= {
    ("gyroscope.scale_nonlinearity", "u |u|"): "ppm/(deg/s)",
    ("gyroscope.scale_nonlinearity", "u^3"): "ppm/(deg/s)^2",
}
_KEYS = {"gyroscope.g_sensitivity": MATRIX, "gyroscope.magnetic": MATRIX, "accelerometer.cross_product": CROSS}
_OF_SENSOR = re.compile(rf"[{''.join(AXES)}](\.[1-{MAX_ORDER}])?")
_WORDS = ("name", "unit", "shape", "definition", "sha256")


def check_effect(entry: Any, where: str) -> None:
    """Raise `DataRefused` for an effect that is none, or whose unit or coefficients are none of its own."""
    if not isinstance(entry, dict):
        raise DataRefused(where, None, f"an effect {shown(entry)}", "its name, unit and coefficients")
    for key in _WORDS:
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
    if expected is None:  # it is left in, and said to be
        return
    if entry.get("unit", expected) != expected and "relaxation" not in name:
        raise DataRefused(where, None, f"{name} in {shown(entry['unit'])}", repr(expected), "convert it")
    keys = _KEYS.get(name)
    for key in entry["coefficients"]:
        is_one = key in keys if keys else _OF_SENSOR.fullmatch(key) or key in UNITS_OF_NONLINEAR
        if not is_one:
            named = ", ".join(keys) if keys else f"x, y, z, or x.1 to z.{MAX_ORDER}"
            raise DataRefused(where, None, f"coefficient {shown(key)} of {name}", named)
