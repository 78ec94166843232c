"""A `calibration/1` as it is exported: triads, provenance, and error terms as sums that a program can compute.

Terms are those of `procedures.effects.term.grammar`, in the calibration's units: g, deg/s, K from 25 degC, K/min,
uT. Beside the inputs of effects of one's own there are ``warming``, 1 while it grows warmer and -1 while it cools,
``c``, the sensor's own coefficient inside a term, and ``sine(y)``, ``sin(x) / x - 1`` of ``y = x^2``.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.cross_product import KEYS as PRODUCTS
from procedures.effects.effect import MATRIX, PLAY, TAU, UNITS_OF_NONLINEAR
from procedures.effects.sagnac_sine import fitted
from procedures.effects.temperature_polynomial import orders_of
from procedures.effects.term.effect_of_term import OUTPUT_UNITS
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, names, parse
from procedures.effects.term.inputs import AUXILIARY, input_of
from procedures.effects.term.units import parse_unit
from procedures.frames import AXES
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.applied_effects import (
    PER_DEG_H,
    POLYNOMIALS,
    POWERS,
    SINE,
    Polynomial,
    left_for_good,
    own_effect,
)
from station.calibrated.correction_inputs import DIRECTION, RATE, WARMTH, Triad
from station.files.calibration_document import MAX_BYTES, parsed_calibration
from station.files.toml_file import read_text_file


@dataclass(frozen=True, slots=True, eq=False)
class StoredCalibration:
    """A calibration/1, its triads by name, and the SHA-256 of its file."""

    path: Path
    document: Mapping[str, Any]
    sha256: str
    triads: Mapping[str, Triad]

    @property
    def unit(self) -> str:
        """Model and serial."""
        return f"{self.document['model']} {self.document['serial']}"

    @property
    def effects(self) -> tuple[Mapping[str, Any], ...]:
        """The entries of its effects."""
        return tuple(self.document["effects"])

    @property
    def temperature_range_c(self) -> tuple[float, float] | None:
        """The least and the greatest temperature [degC] at which it was measured, None where nobody knows."""
        known = self.document.get("temperature_range_c")
        return None if known is None else (float(known[0]), float(known[1]))

    @property
    def origin(self) -> tuple[str, ...]:
        """Whose it is, its hash, when it was accepted and how long it holds: one line each."""
        document, lines = self.document, [f"Calibration of {self.unit}"]
        lines.append(f"SHA-256 of {self.path.name}: {self.sha256}")
        lines.append(
            f"status {document.get('status', 'unknown')}, accepted {document.get('accepted_utc', 'unknown')}"
        )
        until = document.get("valid_until", "not stated")
        lines.append(f"valid from {document.get('valid_from', 'not stated')}, until {until}")
        lines.append(f"made by {document.get('software', 'unknown')}")
        if (known := self.temperature_range_c) is not None:
            lines.append(f"measured at {known[0]:.1f} to {known[1]:.1f} degC")
        return tuple(lines)


def read_stored(path: Path) -> StoredCalibration:
    """Read a calibration/1 to be exported; raises `DataRefused` as `checked_calibration`."""
    content = read_text_file(path, MAX_BYTES)
    checked = parsed_calibration(content, str(path))
    return StoredCalibration(
        path, checked, hashlib.sha256(content).hexdigest(), CalibrationModel.of(checked).triads
    )


Coefficients = Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class CarriedEffect:
    """What an effect adds to a triad's output [g], [deg/s]: ``coefficients`` (3, m), a row a sensor, times terms.

    ``entry`` is where it stands in the calibration.
    """

    name: str
    triad: str
    coefficients: FloatArray
    terms: tuple[Node, ...]
    entry: Mapping[str, Any] = field(default_factory=dict)

    @property
    def inputs(self) -> frozenset[str]:
        """The names in its terms."""
        return frozenset(each.name for term in self.terms for each in names(term))

    @property
    def lags(self) -> tuple[float, ...]:
        """The time constants [s] by which it follows the temperature."""
        return tuple(dict.fromkeys(tau for term in self.terms for tau in _lags(term)))


@dataclass(frozen=True, slots=True)
class NotExported:
    """An effect that is not carried: its name, why, and how large its coefficients are, in words."""

    name: str
    why: str
    size: str

    def __str__(self) -> str:
        return f"{self.name}: {self.why}; {self.size}"


def carried_effects(stored: StoredCalibration) -> tuple[tuple[CarriedEffect, ...], tuple[NotExported, ...]]:
    """Return the effects that a sample and what is remembered of the temperature determine, and the others.

    Raises
    ------
    DataRefused
        If the definition of an effect of one's own is not what was stored.
    """
    carried, left = list[CarriedEffect](), list[NotExported]()
    for entry in stored.effects:
        found: tuple[CarriedEffect, ...] | str = left_for_good(entry)
        if not found:
            found = _own(entry) if "definition" in entry else _of_catalogue(entry)
        if not isinstance(found, str):
            found = _hindrance(found, stored) or found
        if isinstance(found, str):
            left.append(NotExported(str(entry["name"]), found, stated_size(entry)))
        else:
            carried += [replace(one, entry=entry) for one in found if one.triad in stored.triads]
    return tuple(carried), tuple(left)


def input_name(auxiliary: str) -> str:
    """Return the name of an auxiliary channel's input without its prefix."""
    return auxiliary.removeprefix(AUXILIARY)


def _hindrance(found: tuple[CarriedEffect, ...], stored: StoredCalibration) -> str:
    """Return why a program cannot work out an effect whose terms it could; empty if it can."""
    if lacks := _lacking(found, stored):
        return f"there is no calibrated {lacks}"
    odd = sorted(name for one in found for name in one.inputs if not (name.isascii() and name.isidentifier()))
    return f"the channel {odd[0]!r} is no name in a program" if odd else ""


def _lacking(found: tuple[CarriedEffect, ...], stored: StoredCalibration) -> str:
    needed = {"f": "accelerometer", "omega": "gyroscope"}
    for one in found:
        for name in one.inputs:
            triad = needed.get(name.partition("_")[0], one.triad if name in {"u", "out"} else "")
            if one.triad in stored.triads and triad and triad not in stored.triads:
                return triad
    return "" if any(one.triad in stored.triads for one in found) else found[0].triad


def _of_catalogue(entry: Mapping[str, Any]) -> tuple[CarriedEffect, ...] | str:
    name, shape = str(entry["name"]), str(entry.get("shape", ""))
    triad = name.split(".")[0]
    values = {key: float(one["value"]) for key, one in entry["coefficients"].items()}
    if PLAY in values:
        return "exported programs cannot follow temperature hysteresis"
    each = np.array([[values.get(axis, 0.0)] for axis in AXES])
    if name in POLYNOMIALS:
        table, terms = _polynomial(POLYNOMIALS[name], values)
    elif name in _TABLES:
        keys, terms, per = _TABLES[name]
        table = per * np.array([values.get(key, 0.0) for key in keys]).reshape(len(AXES), len(terms))
    elif (row := POWERS[name, shape])[0] == SINE:
        table, terms = fitted(each), (_OF_INPUT[SINE],)
    else:
        table, terms = each * row[1], (_OF_INPUT[row[0]],)
    return (CarriedEffect(name, triad, table, tuple(map(parse, terms))),)


def _polynomial(known: Polynomial, values: Coefficients) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the coefficients (3, m) [g], [deg/s] per K^n and the like of a signal's powers, and these."""
    order = max(orders_of([key for key in values if key != TAU]))
    table = np.zeros((len(AXES), order))
    for row, axis in enumerate(AXES):
        for n in range(1, order + 1):
            first = values.get(axis, 0.0) if n == 1 else 0.0
            table[row, n - 1] = known.per * values.get(f"{axis}.{n}", first)
    base = _SIGNALS.get(known.signal, f"lag(T, {values.get(TAU, 0.0)!r})")
    by = " * out" if known.part == "scale" else ""
    return table, tuple(f"{base}**{n}{by}" if n > 1 else f"{base}{by}" for n in range(1, order + 1))


_SIGNALS = {WARMTH: "T", RATE: "T_rate", DIRECTION: "warming"}
_OF_INPUT = ("abs(u)", "u**2", "u * abs(u)", "u**3", "u * sine(c * u**2)")  # the rows of `POWERS`
_TABLES: Mapping[str, tuple[tuple[str, ...], tuple[str, ...], float]] = {
    "accelerometer.cross_product": (PRODUCTS, ("f_x * f_y", "f_x * f_z", "f_y * f_z"), 1.0),
    "gyroscope.g_sensitivity": (MATRIX, ("f_x", "f_y", "f_z"), PER_DEG_H),
    "gyroscope.magnetic": (MATRIX, ("B_x", "B_y", "B_z"), PER_DEG_H),
}


def _own(entry: Mapping[str, Any]) -> tuple[CarriedEffect, ...] | str:
    """Return an effect of one's own with every unit as a factor."""
    term = own_effect(entry).term
    values = {key: float(one["value"]) for key, one in entry["coefficients"].items()}
    parameters = {name: values[name] * parse_unit(one.unit).size for name, one in term.parameters.items()}
    per = parse_unit(term.unit).size / parse_unit(OUTPUT_UNITS[term.triad]).size
    table = per * np.array([values.get(key, 0.0) for key in term.coefficients]).reshape(len(AXES), len(term.terms))
    terms = tuple(_without_units(node, term.triad, parameters) for node in term.nodes)
    return (CarriedEffect(str(entry["name"]), term.triad, table, terms),)


def _without_units(node: Node, triad: str, parameters: Coefficients) -> Node:
    """Return a term of plain numbers and inputs in the calibration's units, worth what it was in the bases."""
    match node:
        case Number():
            return Number(node.value * (parse_unit(node.unit).size if node.unit else 1.0), "", node.at)
        case Name(name=name) if name == "pi" or name in parameters:
            return Number(parameters.get(name, np.pi), "", node.at)
        case Name(name=name):
            known = input_of(name, triad)
            assert known is not None
            size = parse_unit(known.unit).size
            return node if size == 1.0 else Operation("*", Number(size, "", node.at), node, node.at)
        case Operation():
            left, right = (_without_units(each, triad, parameters) for each in (node.left, node.right))
            return replace(node, left=left, right=right)
        case Call():
            return replace(
                node, arguments=tuple(_without_units(each, triad, parameters) for each in node.arguments)
            )


def _lags(node: Node) -> Iterator[float]:
    match node:
        case Call(name="lag", arguments=(_, Number(value=tau))):
            yield tau
        case Call():
            for each in node.arguments:
                yield from _lags(each)
        case Operation():
            yield from _lags(node.left)
            yield from _lags(node.right)


def stated_size(entry: Mapping[str, Any]) -> str:
    """Return how large an effect is, in words: its largest coefficient, in the unit that says when."""
    beside = own_effect(entry).term.parameters if "definition" in entry else UNITS_OF_NONLINEAR
    sizes = [abs(float(one["value"])) for key, one in entry["coefficients"].items() if key not in beside]
    if not sizes:
        return "its size is not known"
    unit = str(entry.get("unit", ""))
    return f"up to {max(sizes):.3g} {'' if unit == '1' else unit}".rstrip()
