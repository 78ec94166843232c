"""Model refinement over recorded campaigns: solved, diagnosed, and solved again with what was found.

The uncertainty budgets of its solution are written as `budget/1`.
"""

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from procedures.calibration.joint_calibration import CampaignFits, undetectable_tilts_of
from procedures.calibration.solution_values import Solution
from procedures.calibration.undetectable_tilt import undetectable_tilt_warnings
from procedures.diagnosis.diagnose import diagnose
from procedures.effects.excitation import REFERENCE_C
from procedures.errors import NotObservable
from procedures.inference.result import Diagnosis, Finding
from procedures.uncertainty.budget import COVERAGE_PROBABILITY, ParameterBudget, budget
from procedures.uncertainty.sources import GivenValues
from station.errors import DataRefused
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, effects_of
from station.files.toml_file import read_text_file
from station.results.diagnosis.diagnosis_json import (
    diagnosis_json,
    effect_entries,
    finding_document,
    reference_solution,
    temperature_effect,
)
from station.results.diagnosis.magnetic_field import with_magnetic_field

NAME = "diagnosis.json"
MAX_BYTES = 2**26
ALL_POSITIONS = tuple(f"position {number}" for number in range(1, 13))
CARRIED_CONFIDENCES = ("established", "likely")


@dataclass(frozen=True, slots=True, eq=False)
class ModelRefinement:
    """A diagnosis with its `diagnosis/2`, and the solution that a calibration takes from it.

    ``effects`` are those of the instrument that the solution holds, as `calibration/1` carries them.
    """

    diagnosis: Diagnosis
    document: dict[str, Any]
    fits: CampaignFits
    solution: Solution
    effects: tuple[Mapping[str, Any], ...]

    def budgets(self) -> tuple[ParameterBudget, ...]:
        """Return the parameters' uncertainty; what the diagnosis leaves unexplained is in it.

        A clock put right is known as well as its rate is; else it is taken for a quartz.
        """
        found, clock = self.diagnosis, self.diagnosis.clock
        alone = found.bench_alone
        if alone is not None and self.fits is alone.fits:
            left = alone.unexplained
        else:
            left = found.unexplained_before if self.fits is found.before else found.unexplained
        inputs = GivenValues(unexplained=left)
        return budget(self.fits, inputs if clock is None else replace(inputs, clock=clock))


def added_effects(folder: Path) -> list[str]:
    """Return what the diagnosis kept in a campaign's folder added to the model; nothing if there is none."""
    try:
        findings = json.loads(read_text_file(folder / NAME, MAX_BYTES))["findings"]
        return [str(one["effect"]) for one in findings if one["kind"] != "bench"]
    except (DataRefused, ValueError, KeyError, TypeError):  # it is no record: without it the plain solve is right
        return []


def refine_model(campaigns: Sequence[LoadedCampaign]) -> ModelRefinement:
    """Diagnose one unit's campaigns; raises as `procedures.diagnosis.diagnose.diagnose`.

    The calibration is the solution with the effects in, so that it is the one that its effects belong to. Where an
    effect of the instrument is ambiguous it is the solution without any, but for what bench and procedure did: a
    calibration claims nothing of the instrument that is not likely at least.
    """
    campaigns = [with_magnetic_field(one) for one in campaigns]
    files = effects_of(campaigns)
    found = diagnose([one.campaign for one in campaigns], declared=[file.term for file in files])
    if not found.is_calibrated:
        raise NotObservable("the scale factor and bias of either triad", ALL_POSITIONS)
    found = with_undetectable_tilts(found)
    document = diagnosis_json(found, campaigns)
    if any(is_of_unit(each) and each.confidence not in CARRIED_CONFIDENCES for each in found.findings):
        if (alone := found.bench_alone) is not None:
            declared = tuple(effect_entries(alone.declared, files))
            return ModelRefinement(found, document, alone.fits, alone.solution, declared)
        declared = tuple(effect_entries(found.declared_before, files))
        return ModelRefinement(found, document, found.before, found.solution_before, declared)
    reference = reference_solution(found.solution, found.findings)
    solution = replace(found.solution, reference_temperature=reference)
    carried = [_carried(each) for each in found.findings if is_of_unit(each)]
    return ModelRefinement(
        found, document, found.after, solution, (*effect_entries(found.declared, files), *carried)
    )


def with_undetectable_tilts(found: Diagnosis) -> Diagnosis:
    """Say in the solution's warnings where debris would not be detected, since the seatings found say nothing."""
    seatings = {
        (int(str(each.where.get("campaign", 1))) - 1, str(each.where["file"]))
        for each in found.findings
        if each.effect == "placement.dwell"
    }
    alone = found.bench_alone
    return replace(
        found,
        solution=_with_tilts(found.solution, found.after, seatings),
        bench_alone=alone and replace(alone, solution=_with_tilts(alone.solution, alone.fits, seatings)),
    )


def _with_tilts(solution: Solution, fits: CampaignFits, seatings: Collection[tuple[int, str]]) -> Solution:
    if not seatings:
        return solution
    tilts, before = (
        undetectable_tilts_of(fits, solution.quality, seatings),
        undetectable_tilt_warnings(solution.undetectable_tilts),
    )
    kept = [each for each in solution.warnings if each not in before]
    return replace(solution, warnings=(*kept, *undetectable_tilt_warnings(tilts)), undetectable_tilts=tilts)


def is_of_unit(finding: Finding) -> bool:
    """Say whether a finding is one of the instrument in the solution; one of a rate table's file is not."""
    return finding.kind == "instrument" and "file" not in finding.where


def _carried(finding: Finding) -> Mapping[str, Any]:
    """Return one of the ``effects`` of `calibration/1`; ``reference`` is where it vanishes, if it does."""
    text = finding_document(finding)
    entry = {"name": finding.effect, "coefficients": text["coefficients"], "unit": finding.unit}
    if finding.shape:
        entry["shape"] = finding.shape
    if temperature_effect(finding.effect):
        entry["reference"] = {"temperature_c": REFERENCE_C}
    return entry


BUDGET_FORMAT = "budget/1"


def budget_document(budgets: Sequence[ParameterBudget]) -> dict[str, Any]:
    """Return budgets as `budget/1`: an infinite ``dof`` is left out, and a parameter that is not finite."""
    shown = [one for one in budgets if math.isfinite(one.value) and math.isfinite(one.std)]
    return {
        "format": BUDGET_FORMAT,
        "coverage": COVERAGE_PROBABILITY,
        "parameters": [_parameter(one) for one in shown],
    }


def _parameter(one: ParameterBudget) -> dict[str, Any]:
    return {
        "name": one.name,
        "value": one.value,
        "unit": one.unit,
        "std": one.std,
        **_dof(one.dof),
        "coverage_factor": one.coverage_factor,
        "expanded": one.expanded,
        "contributions": [
            {"source": part.source, "type": part.type, "std": part.std, **_dof(part.dof)}
            for part in one.contributions
        ],
    }


def _dof(dof: float) -> dict[str, float]:
    return {"dof": dof} if math.isfinite(dof) else {}
