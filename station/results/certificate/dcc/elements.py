"""Elements of a digital calibration certificate: XML, and quantities of the D-SI in its units.

Every number is written as its shortest exact decimal, so that a reader has the same bits. All units of a
calibration but g are units of the SI or accepted for use with it, and their values pass unchanged; g is 9.80665
m/s2. A count, and a device's own output, is a number: one.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from lxml import etree

from procedures.units import PPM_PER_ONE, STANDARD_GRAVITY
from station.results.certificate.dcc.names import LANGUAGES, Bilingual
from station.results.certificate.signing.xml_schema import DCC, SI

NOT_IN_XML = {code: " " for code in (*range(0x20), 0x7F, 0xFFFE, 0xFFFF) if code not in {0x09, 0x0A}}

Element: TypeAlias = etree._Element  # noqa: SLF001  lxml has no other name for it


Text = Bilingual | str
"""A text in both languages, or one of no language: a name, an address, what people wrote."""


def dcc(name: str, *inside: Element | None, text: str | None = None, **attributes: str | None) -> Element:
    """Return an element of the certificate's namespace with what is given ``inside`` of it; None is left out."""
    return _made(DCC, name, inside, text, attributes)


def si(name: str, *inside: Element | None, text: str | None = None) -> Element:
    """Return an element of the namespace of the D-SI."""
    return _made(SI, name, inside, text, {})


def worded(name: str, text: Text, **attributes: str | None) -> Element:
    """Return an element that holds a text: once for each language, once without one if it has none."""
    if isinstance(text, str):
        return dcc(name, dcc("content", text=text), **attributes)
    both = (dcc("content", text=getattr(text, lang), lang=lang) for lang in LANGUAGES)
    return dcc(name, *both, **attributes)


def _made(
    space: str, name: str, inside: Iterable[Element | None], text: str | None, attributes: dict[str, str | None]
) -> Element:
    made: Element = etree.Element(f"{{{space}}}{name}", nsmap={"dcc": DCC, "si": SI})
    for key, value in attributes.items():
        if value is not None:
            made.set(key, value)
    if text is not None:
        made.text = text.translate(NOT_IN_XML)
    made.extend(one for one in inside if one is not None)
    return made


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


NORMAL = "normal"


@dataclass(frozen=True, slots=True)
class Expanded:
    """An expanded uncertainty in the unit of its value: U, k, the coverage probability, degrees of freedom."""

    uncertainty: float
    coverage_factor: float
    probability: float
    dof: float = math.inf

    @property
    def distribution(self) -> str:
        """The distribution that the coverage factor is of."""
        return NORMAL if math.isinf(self.dof) else "studentT"


def of_normal(uncertainty: float, coverage_factor: float = 1.0) -> Expanded:
    """Return the uncertainty of a normal distribution, standard if no coverage factor is given."""
    return Expanded(uncertainty, coverage_factor, math.erf(coverage_factor / math.sqrt(2)))


def number(value: float) -> str:
    """Return the shortest decimal that is read back as the same float64."""
    return repr(float(value))


def real(value: float, unit: DsiUnit, expanded: Expanded | None = None, label: str | None = None) -> Element:
    """Return a real quantity; value and uncertainty are in the unit of a file, and given in the D-SI's."""
    return si(
        "real",
        None if label is None else si("label", text=label),
        si("value", text=number(unit.of(value))),
        si("unit", text=unit.text),
        None if expanded is None else _expanded(expanded, unit),
    )


def numbers(values: Sequence[float], unit: DsiUnit, labels: Sequence[str] = ()) -> Element:
    """Return a list of real quantities of one unit; a label has no blank."""
    return si(
        "realListXMLList",
        si("labelXMLList", text=" ".join(labels)) if labels else None,
        si("valueXMLList", text=" ".join(number(unit.of(value)) for value in values)),
        si("unitXMLList", text=unit.text),
    )


def quantity(
    name: Bilingual, inside: Element, *extra: Element | None, ref_type: str | None = None, **ids: str
) -> Element:
    """Return a quantity with its name; ``extra`` is what may follow the number."""
    return dcc("quantity", worded("name", name), inside, *extra, refType=ref_type, **ids)


def no_quantity(name: Bilingual, text: Text, ref_type: str | None = None) -> Element:
    """Return a named text in the place of a quantity."""
    return dcc("quantity", worded("name", name), worded("noQuantity", text), refType=ref_type)


def _expanded(one: Expanded, unit: DsiUnit) -> Element:
    return si(
        "expandedUnc",
        si("uncertainty", text=number(unit.of(one.uncertainty))),
        si("coverageFactor", text=number(one.coverage_factor)),
        si("coverageProbability", text=number(one.probability)),
        si("distribution", text=one.distribution),
    )
