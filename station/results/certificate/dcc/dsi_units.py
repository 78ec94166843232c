"""The units of files as the D-SI writes them: what a value is multiplied by, and which powers of which units.

All units of a calibration but g are units of the SI or accepted for use with it, and their values pass unchanged;
g is 9.80665 m/s2. A count, and a device's own output, is a number: one.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from procedures.units import PPM_PER_ONE, STANDARD_GRAVITY


@dataclass(frozen=True, slots=True)
class DsiUnit:
    """Powers of units by their names; a value in the unit of a file is multiplied by ``times`` over ``over``."""

    powers: Mapping[str, int]
    times: float = 1.0
    over: float = 1.0

    @property
    def text(self) -> str:
        r"""The unit as the D-SI writes it: ``\metre\second\tothe{-2}``."""
        parts = [
            f"\\{name}" if power == 1 else f"\\{name}\\tothe{{{power}}}"
            for name, power in self.powers.items()
            if power
        ]
        return "".join(parts) or r"\one"

    def of(self, value: float) -> float:
        """Return a value of the file in this unit: the same number where the units are the same."""
        return value * self.times / self.over

    def __mul__(self, other: "DsiUnit") -> "DsiUnit":
        """Return the unit of a product, as of a covariance."""
        names = dict.fromkeys((*self.powers, *other.powers))
        powers = {name: self.powers.get(name, 0) + other.powers.get(name, 0) for name in names}
        return DsiUnit(powers, self.times * other.times, self.over * other.over)

    def __pow__(self, power: int) -> "DsiUnit":
        """Return a power of the unit."""
        powers = {name: each * power for name, each in self.powers.items()}
        times, over = (self.times, self.over) if power > 0 else (self.over, self.times)
        return DsiUnit(powers, times ** abs(power), over ** abs(power))


ONE = DsiUnit({})
METRE = DsiUnit({"metre": 1})
MILLIMETRE = DsiUnit({"milli\\metre": 1})
SECOND = DsiUnit({"second": 1})
METRE_PER_S2 = METRE * (SECOND * SECOND) ** -1
DEGREE = DsiUnit({"degree": 1})
DEGREE_CELSIUS = DsiUnit({"degreecelsius": 1})
PERCENT = DsiUnit({"percent": 1})
_ATOMS = {  # of units as written in files
    "1": ONE, "count": ONE, "output": ONE,
    "g": DsiUnit(METRE_PER_S2.powers, times=STANDARD_GRAVITY),
    "ppm": DsiUnit({}, over=PPM_PER_ONE),
    "m": METRE, "s": SECOND, "h": DsiUnit({"hour": 1}), "min": DsiUnit({"minute": 1}),
    "deg": DEGREE, "rad": DsiUnit({"radian": 1}), "K": DsiUnit({"kelvin": 1}),
    "uT": DsiUnit({"micro\\tesla": 1}),
}  # fmt: skip
_INNER = re.compile(r"\(([^()]*)\)(?:\^(\d))?")
_FACTOR = re.compile(r"(?P<over>/?)\s*(?P<name>[A-Za-z]+|1|#\d+)(?:\^(?P<power>\d))?\s*")


def dsi_unit(text: str) -> DsiUnit | None:
    """Return a unit as written in files, ``count/(g s)`` or ``ppm/(deg/s)^2``; None where it is no such unit."""
    within = dict[str, DsiUnit | None]()
    while found := _INNER.search(text):
        name, inner = f"#{len(within)}", _product(found[1], within)
        within[name] = None if inner is None else inner ** int(found[2] or 1)
        text = text[: found.start()] + name + text[found.end() :]
    return _product(text, within)


def _product(text: str, within: Mapping[str, DsiUnit | None]) -> DsiUnit | None:
    made, at = ONE, 0
    while at < len(text):
        if (found := _FACTOR.match(text, at)) is None:
            return None
        if (unit := {**_ATOMS, **within}.get(found["name"])) is None:
            return None
        made *= unit ** (int(found["power"] or 1) * (-1 if found["over"] else 1))
        at = found.end()
    return made
