"""What stands beside the results of a digital certificate: effects in the model, global test, as found."""

from collections.abc import Iterator, Mapping
from typing import Any

from station.results.certificate.as_found import COVERAGE, Shift, sigmas
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.dsi_units import ONE, dsi_unit
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.names import as_written, parameter_name
from station.results.certificate.dcc.quantities import no_quantity, number, of_normal, quantity, real
from station.results.certificate.dcc.results import result, unit_of

EFFECTS = Said(
    "Error terms in the model in addition to K, E and D, standard uncertainty u",
    "Fehlerterme im Modell neben K, E und D, Standardunsicherheit u",
)
AS_FOUND = Said(
    "As found: errors with the previous parameters", "Eingangszustand: Abweichungen der vorigen Parameter"
)
APPLIED, ERROR = Said("applied before", "zuvor angewandt"), Said("error as found", "Abweichung")
SIGMAS = Said("error over its standard uncertainty", "Abweichung durch ihre Standardunsicherheit")
FIT = Said("Global test of the fit", "Globaltest der Ausgleichung")
TESTED = {
    "chi2": Said("chi-square", "Chi-Quadrat"),
    "dof": Said("degrees of freedom", "Freiheitsgrade"),
    "p_value": Said("p-value", "p-Wert"),
}
HASH = Said("SHA-256 of its definition", "SHA-256 seiner Definition")


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
        _coefficient(f"{one['name']}.{name}", said, str(units.get(name, one["unit"])))
        for name, said in one["coefficients"].items()
    ]
    if "sha256" in one:
        coefficients.append(no_quantity(HASH, str(one["sha256"]), "fog_effectHash"))
    return dcc(
        "list",
        worded("name", as_written(str(one["name"]))),
        *coefficients or [no_quantity(EFFECTS, Said("no coefficients", "keine Koeffizienten"))],
        refType=f"fog_{one['name']}",
    )


def _coefficient(name: str, said: Mapping[str, float], text: str) -> Element:
    std, unit = said.get("std"), dsi_unit(text)
    if unit is None:  # a unit of somebody's own
        written = f"{number(said['value'])} ({text})" + ("" if std is None else f", u = {number(std)}")
        return no_quantity(as_written(name), written)
    expanded = None if std is None else of_normal(std)
    return quantity(as_written(name), real(said["value"], unit, expanded, label=name))


def _shift(one: Shift) -> Element:
    unit, expanded = unit_of(one.unit), of_normal(one.expanded, COVERAGE)
    return dcc(
        "list",
        worded("name", parameter_name(one.name)),
        quantity(APPLIED, real(one.applied, unit), ref_type="fog_appliedBefore"),
        quantity(ERROR, real(one.error, unit, expanded), ref_type="basic_measurementError"),
        quantity(SIGMAS, real(sigmas(one), ONE), ref_type="fog_errorOverStandardUncertainty"),
        refId=one.name,
        refType="fog_shift",
    )
