"""The results of a digital certificate: parameters with U and k, conformity, budget, covariance, as found.

A list of the D-SI has one unit, but the covariance matrix has one for every pair of kinds. So the matrix is given
as the blocks of its upper triangle, each by rows, labelled ``row|column``. It is the fit's covariance: a
parameter's U also includes sources beyond the fit, and its u^2 is at least the matrix's diagonal.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from procedures.frames import TRIADS
from station.results.certificate import sentences
from station.results.certificate.conformity import AS_FOUND_K, LimitComparison, Shift, sigmas
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.administrative import CONFORMITY
from station.results.certificate.dcc.elements import (
    ONE,
    DsiUnit,
    Element,
    Expanded,
    dcc,
    dsi_unit,
    no_quantity,
    number,
    numbers,
    of_normal,
    quantity,
    real,
    worded,
)
from station.results.certificate.dcc.names import (
    PART_NAMES,
    TRIAD_NAMES,
    Bilingual,
    as_written,
    parameter_name,
    source_name,
)
from station.results.certificate.printed_results import MeasuredParameter

DOF = Bilingual("effective degrees of freedom", "effektive Freiheitsgrade")
LOW, HIGH = Bilingual("lower limit", "untere Grenze"), Bilingual("upper limit", "obere Grenze")
FACTOR = Bilingual("guard band factor r", "Faktor r des Schutzabstands")
BAND = Bilingual("guard band w = r u", "Schutzabstand w = r u")
RISK = Bilingual("probability of a true value outside", "Wahrscheinlichkeit eines wahren Werts außerhalb")
OTHERS = Bilingual("Limited quantities that are no parameters", "Begrenzte Größen, die keine Parameter sind")
NOT_MEASURED = Bilingual("not measured", "nicht gemessen")


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
                title = Bilingual(f"{TRIAD_NAMES[triad].en}: {word.en}", f"{TRIAD_NAMES[triad].de}: {word.de}")
                quantities = [_parameter(one, probability, limited, content) for one in mine]
                yield result(title, *quantities, ref_type=f"fog_{triad}.{part}")
    others = [one for name, one in limited.items() if name not in content.results]
    if others:
        yield result(OTHERS, *(_other(one, content) for one in others), ref_type="fog_limitedQuantities")


def result(name: Bilingual, *inside: Element, ref_type: str) -> Element:
    """Return a result whose data are what is ``inside``."""
    return dcc("result", worded("name", name), dcc("data", *inside), refType=ref_type)


def _parameter(
    one: MeasuredParameter, probability: float, limited: Mapping[str, LimitComparison], content: CertificateContent
) -> Element:
    expanded = Expanded(one.expanded, one.coverage_factor, probability, one.dof)
    extra = [] if math.isinf(one.dof) else [degrees_of_freedom(one.dof)]
    if (compared := limited.get(one.name)) is not None:
        extra.append(_conformity(compared, content))
    return quantity(
        parameter_name(one.name),
        real(one.value, unit_of(one.unit), expanded, label=one.name),
        dcc("measurementMetaData", *extra) if extra else None,
        ref_type=f"basic_measuredValue fog_{one.name}",
        id=one.name,
    )


def degrees_of_freedom(dof: float) -> Element:
    """Return effective degrees of freedom as what a quantity states next to its number."""
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
        worded("declaration", Bilingual(f"Conformity: {word}", f"Konformität: {word}")),
        None if held is None else dcc("conformity", text=held),
        dcc("data", *(quantity(name, real(value, at), ref_type=ref)
                      for name, value, at, ref in known if value is not None)),
        refType="basic_conformity",
    )  # fmt: skip


def _other(one: LimitComparison, content: CertificateContent) -> Element:
    stated = worded("noQuantity", NOT_MEASURED) if one.value is None else real(one.value, unit_of(one.limit.unit))
    extra = dcc("measurementMetaData", _conformity(one, content))
    return quantity(parameter_name(one.limit.parameter), stated, extra, ref_type=f"fog_{one.limit.parameter}")


COVARIANCE_TITLE = Bilingual("Covariance matrix of the fit", "Kovarianzmatrix der Ausgleichung")
COVARIANCE_MEANING = Bilingual(
    "Covariances of the parameters as the least-squares solution gives them, by blocks of the upper triangle, "
    "each by "
    "rows; a label names row and column. The combined uncertainty U / k of a parameter includes sources beyond "
    "the fit, "
    "named in the budget.",
    "Kovarianzen der Parameter, wie die Ausgleichung sie liefert: Blöcke des oberen Dreiecks, jeder "
    "zeilenweise; ein "
    "Etikett nennt Zeile und Spalte. Die kombinierte Unsicherheit U / k eines Parameters enthält auch Quellen "
    "außerhalb der Ausgleichung, die das Budget nennt.",
)


def covariance_results(content: CertificateContent) -> Iterator[Element]:
    """Give the matrix, if the calibration holds one; those stored before there was one do not."""
    stored = content.document.get("covariance", {"names": []})
    if not (groups := _groups(content, stored["names"])):
        return
    kinds = list(groups)
    blocks = [
        _block(content, stored, groups, (row, column))
        for place, row in enumerate(kinds)
        for column in kinds[place:]
    ]
    whole = dcc(
        "list",
        worded("name", COVARIANCE_TITLE),
        worded("description", COVARIANCE_MEANING),
        *blocks,
        refType="fog_covariance",
    )
    yield result(COVARIANCE_TITLE, whole, ref_type="fog_covarianceMatrix")


def _groups(content: CertificateContent, names: list[str]) -> dict[str, list[str]]:
    """Return the parameters of the certificate that the matrix has, by triad and kind."""
    found = dict[str, list[str]]()
    for name in content.results:
        if name in names:
            found.setdefault(name.rpartition(".")[0], []).append(name)
    return found


def _block(
    content: CertificateContent,
    stored: Mapping[str, list[str]],
    groups: dict[str, list[str]],
    pair: tuple[str, str],
) -> Element:
    rows, columns = (groups[kind] for kind in pair)
    at = {name: place for place, name in enumerate(stored["names"])}
    units = [unit_of(content.results[names[0]].unit) for names in (rows, columns)]
    values = [float(stored["matrix"][at[row]][at[column]]) for row in rows for column in columns]
    labels = [f"{row}|{column}" for row in rows for column in columns]
    one, other = (_kind_name(kind) for kind in pair)
    return quantity(
        one + Bilingual(" \u00d7 ", " \u00d7 ") + other,
        numbers(values, units[0] * units[1], labels),
        ref_type="fog_covarianceBlock",
        refId=" ".join(dict.fromkeys((*rows, *columns))),
    )


def _kind_name(kind: str) -> Bilingual:
    triad, part = kind.split(".")
    return TRIAD_NAMES[triad] + Bilingual(" ", ", ") + PART_NAMES[part]


EFFECTS = sentences.EFFECTS + Bilingual(", standard uncertainty u", ", Standardunsicherheit u")
AS_FOUND = Bilingual(
    "As found: errors with the previous parameters", "Eingangszustand: Abweichungen der vorigen Parameter"
)
APPLIED, ERROR = Bilingual("applied before", "zuvor angewandt"), Bilingual("error as found", "Abweichung")
SIGMAS = Bilingual("error over its standard uncertainty", "Abweichung durch ihre Standardunsicherheit")
FIT = Bilingual("Global test of the fit", "Globaltest der Ausgleichung")
TESTED = {
    "chi2": Bilingual("chi-square", "Chi-Quadrat"),
    "dof": Bilingual("degrees of freedom", "Freiheitsgrade"),
    "p_value": Bilingual("p-value", "p-Wert"),
}
HASH = Bilingual("SHA-256 of its definition", "SHA-256 seiner Definition")


def effects_and_global_test(content: CertificateContent) -> Iterator[Element]:
    """Give what there is of them."""
    tested = [
        quantity(name, real(float(residual[key]), ONE), ref_type=f"fog_{key}")
        for residual in [content.document.get("residual", {})]
        for key, name in TESTED.items()
        if key in residual
    ]
    if tested:
        yield result(FIT, dcc("list", *tested), ref_type="fog_globalTest")
    if effects := content.document.get("effects", ()):
        yield result(EFFECTS, *map(_effect, effects), ref_type="fog_effects")
    if content.before is not None and content.before.shifts:
        yield result(AS_FOUND, *map(_shift, content.before.shifts), ref_type="fog_asFound")


def _effect(one: Mapping[str, Any]) -> Element:
    units = one.get("units", {})
    coefficients = [
        _coefficient(f"{one['name']}.{name}", stated, str(units.get(name, one["unit"])))
        for name, stated in one["coefficients"].items()
    ]
    if "sha256" in one:
        coefficients.append(no_quantity(HASH, str(one["sha256"]), "fog_effectHash"))
    return dcc(
        "list",
        worded("name", as_written(str(one["name"]))),
        *coefficients or [no_quantity(EFFECTS, Bilingual("no coefficients", "keine Koeffizienten"))],
        refType=f"fog_{one['name']}",
    )


def _coefficient(name: str, stated: Mapping[str, float], text: str) -> Element:
    std, unit = stated.get("std"), dsi_unit(text)
    if unit is None:  # a unit of somebody's own
        written = f"{number(stated['value'])} ({text})" + ("" if std is None else f", u = {number(std)}")
        return no_quantity(as_written(name), written)
    expanded = None if std is None else of_normal(std)
    return quantity(as_written(name), real(stated["value"], unit, expanded, label=name))


def _shift(one: Shift) -> Element:
    unit, expanded = unit_of(one.unit), of_normal(one.expanded, AS_FOUND_K)
    return dcc(
        "list",
        worded("name", parameter_name(one.name)),
        quantity(APPLIED, real(one.applied, unit), ref_type="fog_appliedBefore"),
        quantity(ERROR, real(one.error, unit, expanded), ref_type="basic_measurementError"),
        quantity(SIGMAS, real(sigmas(one), ONE), ref_type="fog_errorOverStandardUncertainty"),
        refId=one.name,
        refType="fog_shift",
    )


BUDGET_TITLE = Bilingual(
    "Uncertainty budget: contributions, standard uncertainty u",
    "Unsicherheitsbudget: Beiträge, Standardunsicherheit u",
)
COMBINED_U = Bilingual("combined standard uncertainty u", "kombinierte Standardunsicherheit u")


def budget_result(content: CertificateContent) -> Element:
    """Return a list for every parameter, which it names by its id: u, then the contribution of every source."""
    return result(BUDGET_TITLE, *map(_budget_list, content.results.values()), ref_type="fog_uncertaintyBudget")


def _budget_list(one: MeasuredParameter) -> Element:
    unit = unit_of(one.unit)
    combined = quantity(COMBINED_U, real(one.std, unit), ref_type="fog_combinedStandardUncertainty")
    parts = [_contribution(part, unit) for part in one.contributions]
    return dcc(
        "list", worded("name", parameter_name(one.name)), combined, *parts, refId=one.name, refType="fog_budget"
    )


def _contribution(part: Mapping[str, Any], unit: DsiUnit) -> Element:
    dof = float(part.get("dof", math.inf))
    extra = None if math.isinf(dof) else dcc("measurementMetaData", degrees_of_freedom(dof))
    return quantity(
        source_name(str(part["source"])),
        real(part["std"], unit, label=str(part["source"])),
        extra,
        ref_type=f"fog_contribution fog_type{part['type']}",
    )
