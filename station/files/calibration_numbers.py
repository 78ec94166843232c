"""The numbers and units of a `calibration/1`: only such are applied as the station writes."""

from collections.abc import Mapping, Sequence
from reprlib import Repr
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import scale_unit
from procedures.frames import TRIADS
from station.errors import DataRefused

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
    """Say whether a value is text that can be written: JSON may hold halves of characters."""
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
            raise DataRefused(where, None, f"a {name} of nought", "another")
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
