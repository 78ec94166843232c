"""Units of a term: each is a size in g, rad, s, K, uT and the unit of an auxiliary channel, and powers of these.

An angle has a unit of its own: ``sin(omega)`` is refused, ``sin(s * omega)`` with s in rad/(deg/s) is not.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isfinite

from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, parse
from procedures.errors import TermRefused
from procedures.units import RAD_PER_ARCSEC, RAD_PER_DEG, S_PER_H, S_PER_MIN

BASES = ("g", "rad", "s", "K", "uT", "unit")
Powers = tuple[Fraction, ...]
NO_UNIT: Powers = (Fraction(0),) * len(BASES)
MAX_POWER = 12


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit: ``size`` in the bases, ``powers`` of these."""

    size: float
    powers: Powers

    def __mul__(self, other: "Unit") -> "Unit":
        return Unit(self.size * other.size, tuple(a + b for a, b in zip(self.powers, other.powers, strict=True)))

    def __pow__(self, power: Fraction) -> "Unit":
        return Unit(self.size ** float(power), tuple(power * a for a in self.powers))

    def __truediv__(self, other: "Unit") -> "Unit":
        return self * other ** Fraction(-1)


def _of(base: str, size: float) -> Unit:
    return Unit(size, tuple(Fraction(base == each) for each in BASES))


ONE = Unit(1.0, NO_UNIT)
UNITS: Mapping[str, Unit] = {
    "1": ONE, "ppm": Unit(1e-6, NO_UNIT),
    "g": _of("g", 1.0), "mg": _of("g", 1e-3), "ug": _of("g", 1e-6),
    "rad": _of("rad", 1.0), "deg": _of("rad", RAD_PER_DEG), "arcsec": _of("rad", RAD_PER_ARCSEC),
    "s": _of("s", 1.0), "min": _of("s", S_PER_MIN), "h": _of("s", S_PER_H), "Hz": _of("s", 1.0) ** Fraction(-1),
    "K": _of("K", 1.0), "uT": _of("uT", 1.0), "nT": _of("uT", 1e-3), "unit": _of("unit", 1.0),
}  # fmt: skip


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> Unit:
    """Return a unit such as deg/h/(K/min) or ug/g^2.

    Raises
    ------
    TermRefused
        With the place of what is no unit, and the list of what there is.
    """
    if not text.strip():
        raise TermRefused(text, 0, "no unit", f"one of {', '.join(UNITS)} and products of these")
    return _unit(parse(text, is_unit=True), text)


def _unit(node: Node, text: str) -> Unit:
    try:
        found = _worked_out(node, text)
    except ArithmeticError:  # a size beyond floating point
        found = None
    if found is None or not (0 < found.size and isfinite(found.size) and _greatest(found) <= MAX_POWER):
        raise TermRefused(text, node.at, text[node.at : node.at + 8], f"a unit with powers up to {MAX_POWER}")
    return found


def _greatest(unit: Unit) -> Fraction:
    return max(abs(power) for power in unit.powers)


def _worked_out(node: Node, text: str) -> Unit:
    match node:
        case Number(value=1.0, unit=""):
            return ONE
        case Name(name=name) if name in UNITS:
            return UNITS[name]
        case Operation(sign="*", left=left, right=right):
            return _unit(left, text) * _unit(right, text)
        case Operation(sign="/", left=left, right=right):
            return _unit(left, text) / _unit(right, text)
        case Operation(sign="**", left=left, right=right):
            return _unit(left, text) ** power_of(right, text)
    found = node.name if isinstance(node, Name | Call) else text[node.at : node.at + 8]
    raise TermRefused(text, node.at, found, f"one of {', '.join(UNITS)} and products of these")


def power_of(node: Node, text: str) -> Fraction:
    """Return an exponent, which is a plain number."""
    match node:
        case Number(value=value, unit="") if abs(value) <= MAX_POWER:
            return Fraction(value).limit_denominator(1000)
        case Operation(sign="-", left=Number(value=0.0), right=Number(value=value, unit="")) if value <= MAX_POWER:
            return -Fraction(value).limit_denominator(1000)
    raise TermRefused(text, node.at, text[node.at : node.at + 8], f"an exponent: a number up to {MAX_POWER}")


def unit_text(powers: Powers) -> str:
    """Return powers of the bases in words: g s^-1; 1 of none."""
    parts = [f"{base}^{p}" if p != 1 else base for base, p in zip(BASES, powers, strict=True) if p]
    return " ".join(parts) or "1"
