"""A diagnosis as `diagnosis/2` (docs/reference/file-formats.md): JSON-ready, without what is not known."""

import sys
from collections.abc import Mapping, Sequence
from math import exp, isfinite, log
from typing import Any

import numpy as np

from procedures.calibration.solution_values import Solution
from procedures.effects import CATALOGUE
from procedures.effects.excitation import REFERENCE_C
from procedures.evidence.residual_patterns import LeftPattern
from procedures.frames import TRIADS
from procedures.inference.odds import probability
from procedures.inference.result import (
    DeclaredEffect,
    Diagnosis,
    EffectTest,
    Finding,
    Reason,
    ResidualRms,
    TableSensor,
    Unnamed,
)
from procedures.samples.channel_noise import channel_noise
from procedures.samples.held_samples import known_scales
from procedures.uncertainty.budget import ParameterBudget, budget
from procedures.uncertainty.sources import GivenValues
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, effects_of
from station.files.effect_file import EffectFile
from station.files.logs.log_steps import UNCALIBRATED
from station.files.output_units import GYRO_UNITS
from station.results.diagnosis.log_measurements import Recorded, fitted_to, next_in_words, separating
from station.results.diagnosis.uncalibrated import (
    channels_of,
    in_specified_unit,
    output_unit,
    without_solution,
)
from station.results.parameters_by_name import parameters, shifts
from station.results.report.noise_document import noise_channel
from station.results.result_formats import document_of
from station.results.solution_json import solution_document


def effect_entries(solved: Sequence[DeclaredEffect], files: Sequence[EffectFile]) -> list[dict[str, Any]]:
    """Return the ``effects`` of solution/1 and calibration/1; what is not finite is left out.

    ``definition`` is the text of the `effect/1`, ``sha256`` that of its bytes, ``units`` those of its parameters.
    """
    by_name = {one.name: one for one in files}
    return [_entry(each, by_name[each.effect]) for each in solved]


def _entry(solved: DeclaredEffect, file: EffectFile) -> dict[str, Any]:
    values = zip(solved.coefficients, solved.value.tolist(), solved.std.tolist(), strict=True)
    known = {name: {"value": v, "std": s} for name, v, s in values if np.isfinite(v) and np.isfinite(s)}
    units = {name: one.unit for name, one in file.term.parameters.items()}
    return {
        "name": solved.effect, "coefficients": known, "unit": solved.unit, **({"units": units} if units else {}),
        **({"reference": {"temperature_c": REFERENCE_C}} if "T" in file.term.inputs else {}),
        **_definition(file),
    }  # fmt: skip


def own_definition(name: str, files: Sequence[EffectFile]) -> dict[str, Any]:
    """Return the hash and the text of the `effect/1` of a name; nothing of an effect of the catalogue."""
    return next((_definition(file) for file in files if file.name == name), {})


def _definition(file: EffectFile) -> dict[str, Any]:
    return {"term": list(file.term.terms), "sha256": file.sha256, "definition": file.text}


FORMAT = "diagnosis/2"
BLOCKS_LEFT_OUT = "an eighth of the blocks of samples, held out in turn"
LEFT_OUT = "position, rotation, rest, or block of a rate table or soak, held out in turn"


def diagnosis_json(
    diagnosis: Diagnosis,
    campaigns: Sequence[LoadedCampaign],
    validated: Mapping[str, Sequence[ResidualRms]] | None = None,
) -> dict[str, Any]:
    """Return a diagnosis of ``campaigns`` as `diagnosis/2`; ``validated`` are the errors made on other folders."""
    before = document_of(solution_document(diagnosis.solution_before, campaigns))
    files = effects_of(campaigns)
    declared = effect_entries(diagnosis.declared, files)
    after = document_of(solution_document(diagnosis.solution, campaigns, declared))
    if any(temperature_effect(finding.effect) for finding in diagnosis.findings):
        after["reference_temperature_c"] = REFERENCE_C
    if diagnosis.on_table:
        counts = campaigns[0].tables.imu.output != "rate"
        name = "count/s" if counts else output_unit(campaigns, "gyroscope")
        after["rate_tables"] = _on_table(diagnosis.on_table, name)
        nominal = campaigns[0].campaign.nominal_scale.get("gyroscope")
        after["warnings"] = [*after.get("warnings", ()), *_in_other_units(diagnosis.on_table, nominal)]
    errors = [
        error_document(each, BLOCKS_LEFT_OUT if each.quantity.endswith("samples") else LEFT_OUT)
        for each in diagnosis.errors
    ]
    for folder, found in (validated or {}).items():
        errors += [error_document(each, f"validation: {folder}") for each in found]
    has_plan = any(one.campaign.dwells for one in campaigns)  # its turns are as few as they may be, by design
    if not has_plan and (far := _far_above(diagnosis.errors)):
        after["warnings"] = [*after.get("warnings", ()), *far]
    channels = channels_of(campaigns, [triad for triad in TRIADS if triad in before])
    recorded = Recorded.of(campaigns)
    findings = [
        fitted_to(recorded, finding_document(finding) | own_definition(finding.effect, files))
        for finding in diagnosis.findings
    ]
    if not diagnosis.is_calibrated:
        findings = [in_specified_unit(finding, finding["effect"], campaigns) for finding in findings]
        errors = [in_specified_unit(error, error["quantity"], campaigns) for error in errors]
    return {
        "format": FORMAT,
        "recording": recorded.kind,
        "verdict": diagnosis.verdict,
        "p_value": max(exp(min(float(diagnosis.log_p), 0.0)), sys.float_info.min),
        "log10_p": float(diagnosis.log_p) / log(10),
        "reasons": [reason_document(each) for each in diagnosis.reasons],
        "findings": findings,
        "error": errors,
        "parameters": moved(before, after),
        **({"solution": after} if diagnosis.is_calibrated else without_solution(campaigns)),
        "unnamed": [unnamed_document(each) for each in diagnosis.unnamed],
        "probabilities": probabilities_document(diagnosis.probabilities),
        "not_separable": {
            name: way if recorded.kind == "campaign" else separating(recorded, name).phrase
            for name, way in diagnosis.not_separable.items()
        },
        "tests": [test_document(each) for each in diagnosis.tried],
        "next_measurement": next_in_words(recorded, findings, diagnosis.next_measurement),
        **({"left": [left_document(each) for each in diagnosis.left]} if diagnosis.left else {}),
        **({"channels": channels} if channels else {}),
    }


MAX_HELD_OUT_RATIO = (
    3.0  # as where two thirds of the rows go into parameters: of n rows and p of these it is 1/(1 - p/n)
)


def _far_above(errors: Sequence[ResidualRms]) -> list[str]:
    """Return a warning for each error on held-out data that is far above that in the data."""
    return [
        f"{one.quantity}: the error on held-out data is {one.held_out_after / one.after:.1f} times that in the "
        "data: there are few of them for so many parameters; record more of them that differ"
        for one in errors
        if one.held_out_after is not None and one.held_out_after > MAX_HELD_OUT_RATIO * one.after > 0
    ]


def finding_document(finding: Finding) -> dict[str, Any]:
    """Return a finding; a number that was not computed is absent."""
    value, std = np.atleast_1d(finding.value), np.atleast_1d(finding.std)
    known = np.isfinite(value) & np.isfinite(std)
    return {
        "effect": finding.effect,
        "kind": finding.kind,
        "coefficients": {
            name: {"value": float(value[i]), "std": float(std[i])}
            for i, name in enumerate(finding.coefficients)
            if known[i]
        },
        "unit": finding.unit,
        "where": {name: plain(what) for name, what in finding.where.items()},
        "probability": float(finding.probability),
        "confidence": finding.confidence,
        **({} if finding.joint is None else {"joint_probability": float(finding.joint)}),
        **({"shares": {name: float(p) for name, p in finding.shares.items()}} if finding.shares else {}),
        **({} if finding.share is None else {"share": float(finding.share)}),
        "aliases": list(finding.aliases),
        "separate_by": finding.separate_by,
        **({"error": [error_document(each, LEFT_OUT) for each in finding.errors]} if finding.errors else {}),
        **({} if finding.times_expected is None else {"times_expected": float(finding.times_expected)}),
        **({"same_here": list(finding.same_here)} if finding.same_here else {}),
        **({"shape": finding.shape} if finding.shape else {}),
        **({"fault": finding.fault} if finding.fault else {}),
    }


def unnamed_document(cause: Unnamed) -> dict[str, Any]:
    """Return a cause without a name: ``what`` it looks like, its probability, and what it may be instead."""
    return {
        "what": cause.what, "note": cause.note, "probability": float(cause.probability),
        "joint_probability": float(cause.joint), "shares": {name: float(p) for name, p in cause.shares.items()},
    }  # fmt: skip


def probabilities_document(probabilities: Mapping[str, float]) -> dict[str, float]:
    """Return the probability of every name that was considered, the likeliest first."""
    return {
        name: float(probabilities[name]) for name in sorted(probabilities, key=lambda one: -probabilities[one])
    }


def reason_document(reason: Reason) -> dict[str, Any]:
    """Return a reason: ``code``, ``what`` it is about, and the ``value`` that was computed, if any."""
    value = {} if reason.value is None or not isfinite(reason.value) else {"value": float(reason.value)}
    return {"code": str(reason.code), **({"what": reason.what} if reason.what else {}), **value}


def left_document(pattern: LeftPattern) -> dict[str, Any]:
    """Return where what is left shows, see `procedures.evidence.residual_patterns`."""
    return {
        "by": pattern.by, "what": pattern.what, "size": float(pattern.size),
        "log10_p": float(pattern.log_p) / log(10),
    }  # fmt: skip


def _on_table(sensors: Sequence[TableSensor], output: str) -> dict[str, Any]:
    """Return what rate tables say of the gyroscopes they turned, by sensor: a triad's vectors need all three.

    What stands at rest is a bias in deg/h, or the offset of an analogue output in that output's unit.
    """
    biased, offset = ([each for each in sensors if each.is_offset is so] for so in (False, True))
    found: dict[str, Any] = {
        "scale_factor": {each.axis: {"value": each.scale, "std": each.scale_std} for each in sensors}
    }
    unit = {"scale_factor": "count/deg" if output == "count/s" else f"{output}/(deg/s)"}
    if biased:
        found["bias"] = {each.axis: {"value": each.bias, "std": each.bias_std} for each in biased}
        unit["bias"] = "deg/h"
    if offset:
        found["offset"] = {each.axis: {"value": each.offset, "std": each.offset_std} for each in offset}
        unit["offset"] = output
    return {"gyroscope": found, "unit": unit}


def _in_other_units(sensors: Sequence[TableSensor], nominal: float | None) -> list[str]:
    """Return a warning for each sensor whose scale factor is that of another unit than the one specified.

    ``nominal`` is how many outputs are 1 deg/s in the unit that is specified, None where none is.
    """
    by_size = {per: unit for unit, per in GYRO_UNITS.items()}
    return [
        f"gyroscope {each.axis}: a scale factor of {each.scale:.6g} output/(deg/s) is that of outputs in {unit}, "
        f"not in {by_size[nominal]}: the unit in the name of the column, or of the reference, is probably wrong"
        for each in sensors for per, unit in by_size.items()
        if nominal in by_size and per != nominal and abs(abs(each.scale) / per - 1) < UNCALIBRATED
    ]  # fmt: skip


def temperature_effect(name: str) -> bool:
    """Say whether an effect of the catalogue makes other parameters hold at the reference temperature alone."""
    return name in CATALOGUE and CATALOGUE[name].is_of_steady_temperature


def moved(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return by how much each parameter that two solution/1 hold moved, in sigmas of the latter."""
    earlier = parameters(before)
    return [
        {"name": name, "before": earlier[name].value, "after": one.parameter.value,
         "std": one.parameter.std, "unit": one.parameter.unit, "shift_sigma": one.sigmas}
        for name, one in shifts(parameters(after), earlier, lambda now, _: now.std or 0.0).items()
    ]  # fmt: skip


def reference_solution(solution: Solution, findings: Sequence[Finding]) -> float | None:
    """Return the temperature [degC] at which a solution's parameters hold."""
    return REFERENCE_C if any(temperature_effect(f.effect) for f in findings) else solution.reference_temperature


def plain(value: object) -> Any:
    """Return a value of numpy's or Python's as JSON has it."""
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return value


def test_document(test: EffectTest) -> dict[str, Any]:
    """Return what was looked for before the inference, with its probability where it is likeliest."""
    return {"effect": test.effect, "probability": probability(test.log_odds)}


def error_document(error: ResidualRms, method: str) -> dict[str, Any]:
    """Return an error before and after, as far as it is known; ``method`` says how rows were held out."""
    names = ("before", "after", "held_out_before", "held_out_after")
    known = {name: float(v) for name in names if (v := getattr(error, name)) is not None and isfinite(v)}
    return {"quantity": error.quantity, "unit": error.unit, **known, "method": method}


MAX_WIDENED = 6
MIN_GROWTH = 1.01  # of U, from which on a parameter is listed


def noise_and_widened(campaigns: Sequence[LoadedCampaign], found: Diagnosis | None) -> dict[str, Any]:
    """Return ``noise``, as the channels of `noise/1`, and ``widened``; each absent where there is none."""
    bare = [one.campaign for one in campaigns]
    scales = known_scales(bare, None if found is None else found.solution)
    found_noise = channel_noise(bare, scales)
    noise = [document_of(noise_channel(each, output_unit(campaigns, each.triad))) for each in found_noise]
    widened = [] if found is None else _widened(found)
    return {name: part for name, part in (("noise", noise), ("widened", widened)) if part}


def _widened(found: Diagnosis) -> list[dict[str, Any]]:
    """Return the parameters whose expanded uncertainty what is left widens most, the worst first."""
    if found.unexplained is None or not (found.solution.accelerometer or found.solution.gyroscope):
        return []
    given = GivenValues() if found.clock is None else GivenValues(clock=found.clock)
    without = {each.name: each for each in budget(found.after, given)}
    left = GivenValues(unexplained=found.unexplained, clock=given.clock)
    pairs = [(without[each.name], each) for each in budget(found.after, left)]
    grown = [pair for pair in pairs if pair[1].expanded > MIN_GROWTH * pair[0].expanded]
    worst = sorted(grown, key=lambda pair: -pair[1].expanded / max(pair[0].expanded, 1e-300))
    return [_widened_document(*pair) for pair in worst[:MAX_WIDENED]]


def _widened_document(without: ParameterBudget, one: ParameterBudget) -> dict[str, Any]:
    return {
        "name": one.name, "unit": one.unit, "expanded_without": without.expanded, "expanded": one.expanded
    }  # fmt: skip
