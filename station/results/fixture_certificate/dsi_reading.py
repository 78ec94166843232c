r"""Quantities of the D-SI as others write them: ``\arcsecond``, ``\milli\metre``, ``\micro\metre\per\metre``.

A unit is prefix, name and power, each after a backslash: PTB, Digital System of Units, 2.1. What is read is
brought to metres and radians. A slope, a length by a length, is taken for its angle: under 0.1 mrad they agree
in 1e-8.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

SI = "{https://ptb.de/si}"
PREFIXES = {
    "nano": 1e-9, "micro": 1e-6, "milli": 1e-3, "centi": 1e-2, "deci": 1e-1, "kilo": 1e3,
}  # fmt: skip
UNITS: Mapping[str, tuple[float, str]] = {
    "metre": (1.0, "metre"),
    "radian": (1.0, "radian"),
    "degree": (math.pi / 180, "radian"),
    "arcminute": (math.pi / 180 / 60, "radian"),
    "arcsecond": (math.pi / 180 / 3600, "radian"),
    "one": (1.0, ""),
}
_PART = re.compile(r"\\([a-z]+)(?:\{(-?\d)\})?")
_PARTS = re.compile(rf"(?:{_PART.pattern})+", re.ASCII)
Kind = tuple[str, ...]
LENGTH: Kind = ("metre",)
ANGLE: Kind = ("radian",)
NUMBER: Kind = ()
ANGLE_SQUARED: Kind = ("radian", "radian")


class NoQuantity(ValueError):
    """Something is no quantity that is read; ``found`` and ``expected`` say what and why."""

    def __init__(self, found: str, expected: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"found {found}, expected {expected}")


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as a number of metres and radians: its factor, and which of them, each as often as its power."""

    factor: float
    kind: Kind


@dataclass(frozen=True, slots=True)
class Quantity:
    """A value in the unit ``kind`` is of, with 1 sigma; None where no uncertainty is given."""

    value: float
    std: float | None
    kind: Kind


def read_unit(text: str) -> Unit:
    """Return a unit of the D-SI; raise `NoQuantity` if it is none that is known here."""
    text, factor, prefix, power = text.strip(), 1.0, 1.0, 1
    powers = dict[str, int]()
    last: tuple[float, str, int] | None = None
    if not _PARTS.fullmatch(text):
        raise NoQuantity(_shown(text), _known())
    for name, exponent in _PART.findall(text):
        if name == "tothe" and last is not None and exponent:
            size, kind, sign = last
            more = sign * int(exponent) - sign
            factor *= size**more
            powers[kind] = powers.get(kind, 0) + more
        elif exponent:
            raise NoQuantity(_shown(text), _known())
        elif name == "per":
            power = -1
        elif name in PREFIXES:
            prefix = PREFIXES[name]
        elif name in UNITS:
            size, kind = prefix * UNITS[name][0], UNITS[name][1]
            factor, last = factor * size**power, (size, kind, power)
            powers[kind] = powers.get(kind, 0) + power
            prefix, power = 1.0, 1
        else:
            raise NoQuantity(_shown(text), _known())
    if prefix != 1.0 or power != 1 or any(n < 0 for kind, n in powers.items() if kind):
        raise NoQuantity(_shown(text), _known())
    return Unit(factor, tuple(kind for kind, n in sorted(powers.items()) for _ in range(n) if kind))


def _shown(text: str) -> str:
    """Return a unit for a message: its backslashes as they stand, but nothing that moves a terminal."""
    return f"unit '{text[:40]}'" if text.isprintable() else f"unit {text[:40]!a}"


def _known() -> str:
    return f"one made of {', '.join(sorted(UNITS))}, as the D-SI writes it"


def read_real(element: Any) -> Quantity:
    """Return what a ``si:real`` says; raise `NoQuantity` if it is no number, or its uncertainty none."""
    unit = read_unit(element.findtext(f"{SI}unit") or "")
    value = _number(element.findtext(f"{SI}value"))
    std = _std(element)
    return Quantity(value * unit.factor, None if std is None else std * unit.factor, unit.kind)


def _std(element: Any) -> float | None:
    """Return 1 sigma in the unit of the value: U / k, or the standard uncertainty of an interval."""
    expanded = element.find(f"{SI}expandedUnc")
    if expanded is None:  # as later versions have it
        expanded = element.find(f"{SI}measurementUncertaintyUnivariate/{SI}expandedMU")
    if expanded is not None:
        U = expanded.findtext(f"{SI}uncertainty") or expanded.findtext(f"{SI}valueExpandedMU")
        std = _number(U) / _positive(expanded.findtext(f"{SI}coverageFactor"), "coverage factor k")
    else:
        interval = element.find(f"{SI}coverageInterval")
        if interval is None:
            return None
        std = _number(interval.findtext(f"{SI}standardUnc"))
    if not std > 0:
        raise NoQuantity(f"an uncertainty of {std:g}", "one above 0")
    return std


def _positive(text: str | None, what: str) -> float:
    if not (number := _number(text)) > 0:
        raise NoQuantity(f"{what} {number:g}", "one above 0")
    return number


def _number(text: str | None) -> float:
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise NoQuantity(f"{(text or 'nothing')[:40]!r}", "a number")
    return number
