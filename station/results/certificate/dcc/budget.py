"""The uncertainty budget of a digital certificate: for every parameter what each source adds to it."""

import math
from collections.abc import Mapping
from typing import Any

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.dsi_units import DsiUnit
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.names import parameter_name, source_name
from station.results.certificate.dcc.quantities import quantity, real
from station.results.certificate.dcc.results import degrees_of_freedom, result, unit_of
from station.results.certificate.printed_results import MeasuredParameter

TITLE = Said(
    "Uncertainty budget: contributions, standard uncertainty u",
    "Unsicherheitsbudget: Beiträge, Standardunsicherheit u",
)
COMBINED = Said("combined standard uncertainty u", "kombinierte Standardunsicherheit u")


def budget_result(content: CertificateContent) -> Element:
    """Return a list for every parameter, which it names by its id: u, then the contribution of every source."""
    return result(TITLE, *map(_parameter, content.results.values()), ref_type="fog_uncertaintyBudget")


def _parameter(one: MeasuredParameter) -> Element:
    unit = unit_of(one.unit)
    combined = quantity(COMBINED, real(one.std, unit), ref_type="fog_combinedStandardUncertainty")
    parts = [_contribution(part, unit) for part in one.contributions]
    return dcc(
        "list", worded("name", parameter_name(one.name)), combined, *parts, refId=one.name, refType="fog_budget"
    )


def _contribution(part: Mapping[str, Any], unit: DsiUnit) -> Element:
    dof = float(part.get("dof", math.inf))
    beside = None if math.isinf(dof) else dcc("measurementMetaData", degrees_of_freedom(dof))
    return quantity(
        source_name(str(part["source"])),
        real(part["std"], unit, label=str(part["source"])),
        beside,
        ref_type=f"fog_contribution fog_type{part['type']}",
    )
