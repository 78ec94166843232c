"""The effects that a calibration carries: what a diagnosis found of the instrument and is sure of."""

from collections.abc import Mapping, Sequence
from typing import Any

from procedures.diagnosis.result import Finding
from procedures.effects.effect import REFERENCE_C
from station.results.diagnosis.diagnosis_json import finding_document, temperature_effect

SURE = ("established", "likely")


def carried_effects(findings: Sequence[Finding]) -> tuple[Mapping[str, Any], ...]:
    """Return ``effects`` of `calibration/1`: name, coefficients, unit and, where they vanish at one, reference."""
    return tuple(_carried(each) for each in findings if is_of_unit(each) and each.confidence in SURE)


def is_of_unit(finding: Finding) -> bool:
    """Say whether a finding is one of the instrument in the solution; one of a rate table's file is beside it."""
    return finding.kind == "instrument" and "file" not in finding.where


def _carried(finding: Finding) -> Mapping[str, Any]:
    said = finding_document(finding)
    entry = {"name": finding.effect, "coefficients": said["coefficients"], "unit": finding.unit}
    if finding.shape:
        entry["shape"] = finding.shape
    if temperature_effect(finding.effect):
        entry["reference"] = {"temperature_c": REFERENCE_C}
    return entry
