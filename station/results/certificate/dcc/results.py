"""The results of a digital certificate: every parameter with U, k and probability, beside it its conformity."""

import math
from collections.abc import Iterator, Mapping

from procedures.frames import TRIADS
from station.results.certificate.conformity import LimitComparison
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.conformity_statements import CONFORMITY
from station.results.certificate.dcc.dsi_units import ONE, DsiUnit, dsi_unit
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.names import PART_NAMES, TRIAD_NAMES, parameter_name
from station.results.certificate.dcc.quantities import Expanded, quantity, real
from station.results.certificate.printed_results import MeasuredParameter

DOF = Said("effective degrees of freedom", "effektive Freiheitsgrade")
LOW, HIGH = Said("lower limit", "untere Grenze"), Said("upper limit", "obere Grenze")
FACTOR = Said("guard band factor r", "Faktor r des Schutzabstands")
BAND = Said("guard band w = r u", "Schutzabstand w = r u")
RISK = Said("probability of a true value outside", "Wahrscheinlichkeit eines wahren Werts außerhalb")
OTHERS = Said("Limited quantities that are no parameters", "Begrenzte Größen, die keine Parameter sind")
NOT_MEASURED = Said("not measured", "nicht gemessen")


def unit_of(text: str) -> DsiUnit:
    """Return the unit of a parameter, as written in files; raise `ValueError` of one that the D-SI cannot say."""
    if (unit := dsi_unit(text)) is None:
        raise ValueError(f"no unit of the D-SI for {text!r}")
    return unit


def parameter_results(content: CertificateContent) -> Iterator[Element]:
    """Give the parameters by triad and kind, then what else was held against a limit."""
    limited = {} if content.found is None else {one.limit.parameter: one for one in content.found.against}
    probability = float(content.document["uncertainty"]["coverage"])
    for triad in TRIADS:
        for part, word in PART_NAMES.items():
            mine = [one for name, one in content.results.items() if name.startswith(f"{triad}.{part}.")]
            if mine:
                title = Said(f"{TRIAD_NAMES[triad].en}: {word.en}", f"{TRIAD_NAMES[triad].de}: {word.de}")
                quantities = [_parameter(one, probability, limited, content) for one in mine]
                yield result(title, *quantities, ref_type=f"fog_{triad}.{part}")
    others = [one for name, one in limited.items() if name not in content.results]
    if others:
        yield result(OTHERS, *(_other(one, content) for one in others), ref_type="fog_limitedQuantities")


def result(name: Said, *inside: Element, ref_type: str) -> Element:
    """Return a result whose data are what is ``inside``."""
    return dcc("result", worded("name", name), dcc("data", *inside), refType=ref_type)


def _parameter(
    one: MeasuredParameter, probability: float, limited: Mapping[str, LimitComparison], content: CertificateContent
) -> Element:
    expanded = Expanded(one.expanded, one.coverage_factor, probability, one.dof)
    beside = [] if math.isinf(one.dof) else [degrees_of_freedom(one.dof)]
    if (compared := limited.get(one.name)) is not None:
        beside.append(_conformity(compared, content))
    return quantity(
        parameter_name(one.name),
        real(one.value, unit_of(one.unit), expanded, label=one.name),
        dcc("measurementMetaData", *beside) if beside else None,
        ref_type=f"basic_measuredValue fog_{one.name}",
        id=one.name,
    )


def degrees_of_freedom(dof: float) -> Element:
    """Return effective degrees of freedom as what a quantity says beside its number."""
    data = dcc("data", quantity(DOF, real(dof, ONE)))
    return dcc("metaData", data, refType="fog_effectiveDegreesOfFreedom")


def _conformity(compared: LimitComparison, content: CertificateContent) -> Element:
    limit, unit = compared.limit, unit_of(compared.limit.unit)
    held = None if content.certificate.reasons else CONFORMITY.get(compared.word)
    known = [
        (LOW, limit.low, unit, "fog_lowerLimit"), (HIGH, limit.high, unit, "fog_upperLimit"),
        (FACTOR, limit.guard_band, ONE, "fog_guardBandFactor"),
        (BAND, compared.guard, unit, "fog_guardBand"), (RISK, compared.risk, ONE, "fog_risk"),
    ]  # fmt: skip
    word = compared.word.replace("_", " ")
    return dcc(
        "metaData",
        dcc("norm", text="JCGM 106:2012, 8.3"),
        worded("declaration", Said(f"Conformity: {word}", f"Konformität: {word}")),
        None if held is None else dcc("conformity", text=held),
        dcc("data", *(quantity(name, real(value, at), ref_type=ref)
                      for name, value, at, ref in known if value is not None)),
        refType="basic_conformity",
    )  # fmt: skip


def _other(one: LimitComparison, content: CertificateContent) -> Element:
    said = worded("noQuantity", NOT_MEASURED) if one.value is None else real(one.value, unit_of(one.limit.unit))
    beside = dcc("measurementMetaData", _conformity(one, content))
    return quantity(parameter_name(one.limit.parameter), said, beside, ref_type=f"fog_{one.limit.parameter}")
