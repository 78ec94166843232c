"""Quantities of the D-SI: every number as its shortest exact decimal, so that a reader has the same bits."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from station.results.certificate.dcc.dsi_units import DsiUnit
from station.results.certificate.dcc.elements import Element, Said, Text, dcc, si, worded

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
    """Return the uncertainty of a normal distribution, 1 sigma if no coverage factor is given."""
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
    name: Said, inside: Element, *beside: Element | None, ref_type: str | None = None, **ids: str
) -> Element:
    """Return a quantity with its name; ``beside`` is what may follow the number."""
    return dcc("quantity", worded("name", name), inside, *beside, refType=ref_type, **ids)


def no_quantity(name: Said, text: Text, ref_type: str | None = None) -> Element:
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
