"""A certificate of a cube or a slab as read from a DCC: tilts with covariance, item, issuer, number and days."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.results.certificate.signing.xml_schema import NAMESPACES
from station.results.fixture_certificate.dsi_reading import (
    ANGLE,
    ANGLE_SQUARED,
    LENGTH,
    NUMBER,
    Kind,
    NoQuantity,
    Quantity,
    read_real,
)
from station.results.fixture_certificate.quantity_names import SIDE, SLAB, Known, known_quantity

DUE = "fog_dueDate"


@dataclass(frozen=True, slots=True, eq=False)
class Tilt:
    """An up vector's two components (2,) [rad] and their covariance (2, 2) [rad2]."""

    value: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FixtureDocument:
    """What a certificate says of a fixture: by face, or of a slab alone; ``side`` [m] where it gives one."""

    items: tuple[str, ...]
    laboratory: str
    number: str
    measured: date
    due: date | None
    tilts: dict[str, Tilt]
    side: float | None


def read_fixture(document: Any, where: str | Path) -> FixtureDocument:
    """Return what a DCC says; raise `DataRefused` where it says what is not known here, or too little."""
    found = dict[Known, Quantity]()
    for name, known, element in _quantities(document):
        try:
            if known is None:
                expected = "those of docs/how-to/certificate-signing.md"
                raise NoQuantity("a quantity of no known refType or name", expected)
            if known in found:
                raise NoQuantity("the same quantity twice", "each once")
            found[known] = _checked(known, read_real(element))
        except NoQuantity as error:
            remedy = "ask the laboratory, or add it by `station fixtures add`"
            raise DataRefused(
                where, element.sourceline, f"{name!r}: {error.found}", error.expected, remedy
            ) from error
    if not (tilts := _tilts(found, where)):
        raise DataRefused(where, None, "no tilt of a cube's face or a surface plate", "one or more with U")
    text = _Texts(document, where)
    side = found.get(Known(SIDE))
    return FixtureDocument(
        text.items(), text.one(".//dcc:calibrationLaboratory/dcc:contact/dcc:name/dcc:content"),
        text.one(".//dcc:coreData/dcc:uniqueIdentifier"), text.day(".//dcc:coreData/dcc:endPerformanceDate"),
        text.due(), tilts, None if side is None else side.value,
    )  # fmt: skip


def _quantities(document: Any) -> Iterator[tuple[str, Known | None, Any]]:
    """Yield each quantity of the results: its name for people, what it is, and its element."""
    for result in document.iterfind(".//dcc:results/dcc:result", NAMESPACES):
        names = _names(result)
        inside = [*result.iterfind("dcc:data/dcc:quantity", NAMESPACES)]
        inside += result.iterfind("dcc:data/dcc:list//dcc:quantity", NAMESPACES)
        for quantity in inside:
            own = _names(quantity)
            of_result = len(inside) == 1
            types = f"{quantity.get('refType', '')} {result.get('refType', '') if of_result else ''}"
            known = known_quantity(types, [*own, *(names if of_result else [])])
            real = quantity.find("si:real", NAMESPACES)
            yield next(iter([*own, *names]), "quantity"), known, quantity if real is None else real


def _names(element: Any) -> list[str]:
    return [one.text or "" for one in element.iterfind("dcc:name/dcc:content", NAMESPACES)]


def _checked(known: Known, quantity: Quantity) -> Quantity:
    """Return a quantity whose unit and uncertainty are those of what it is; raise `NoQuantity` if they are not."""
    expected, kinds = _kinds(known)
    if quantity.kind not in kinds:
        raise NoQuantity(f"a unit of {' '.join(quantity.kind) or 'one'}", expected)
    if known.component != 2 and known.part != SIDE and quantity.std is None:
        raise NoQuantity("no expanded uncertainty U", "one with its k")
    return quantity


def _kinds(known: Known) -> tuple[str, tuple[Kind, ...]]:
    """Return the units that a quantity may have, in words and as they are."""
    if known.part == SIDE:
        return "a length", (LENGTH,)
    if known.component == 2:
        return "a correlation (one) or a covariance (an angle squared)", (NUMBER, ANGLE_SQUARED)
    return "an angle, or a slope", (ANGLE, NUMBER)


def _tilts(found: dict[Known, Quantity], where: str | Path) -> dict[str, Tilt]:
    made = dict[str, Tilt]()
    for part in dict.fromkeys(known.part for known in found if known.part != SIDE):
        first, second = found.get(Known(part, 0)), found.get(Known(part, 1))
        if first is None or second is None or first.std is None or second.std is None:
            raise DataRefused(where, None, f"one component of the tilt of {part}", "both")
        both = found.get(Known(part, 2))
        product = first.std * second.std
        shared = 0.0 if both is None else both.value * (product if both.kind == NUMBER else 1.0)
        if abs(shared) > product:
            raise DataRefused(where, None, f"correlation {shared / product:g} of {part}", "one from -1 to 1")
        covariance = np.array([[first.std**2, shared], [shared, second.std**2]])
        made[part] = Tilt(np.array([first.value, second.value]), covariance)
    if SLAB in made and len(made) > 1:
        raise DataRefused(where, None, "tilts of a surface plate and of a cube", "those of one of them")
    return made


class _Texts:
    """The texts of a document that it cannot do without."""

    def __init__(self, document: Any, where: str | Path) -> None:
        self._document, self._where = document, where

    def one(self, path: str) -> str:
        found = self._document.find(path, NAMESPACES)
        if found is None or not (found.text or "").strip():
            raise DataRefused(self._where, None, f"no {path.rpartition(':')[2]}", "one", "ask the laboratory")
        return " ".join(str(found.text).split())

    def day(self, path: str) -> date:
        text = self.one(path)
        try:
            return date.fromisoformat(text[:10])
        except ValueError as error:
            raise DataRefused(self._where, None, f"day {text[:20]!r}", "a date such as 2026-03-04") from error

    def due(self) -> date | None:
        for statement in self._document.iterfind(".//dcc:statements/dcc:statement", NAMESPACES):
            if DUE in (statement.get("refType") or "").split():
                return self.day(f".//dcc:statement[@refType='{statement.get('refType')}']/dcc:date")
        return None

    def items(self) -> tuple[str, ...]:
        found = self._document.iterfind(".//dcc:items//dcc:identification/dcc:value", NAMESPACES)
        return tuple(" ".join((one.text or "").split()) for one in found)
