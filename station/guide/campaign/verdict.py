"""The end of a calibration: the verdict, what changed since the last one, and the numbers, as they are shown."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from fixtures_db.database import Database
from fixtures_db.stored_calibrations import last_calibration
from procedures.calibration.solution_values import StepResidual
from procedures.frames import AXES
from station.files.campaign_folder.plan_file import read_left_out
from station.guide.step_names import gap_in_words, verdict_without_file_names
from station.guide.view import Verdict, VerdictRow
from station.results.contradictory_dwells import worst_kept
from station.results.diagnosis.diagnosis_text import diagnosis_text
from station.results.diagnosis.diagnosis_wording import verdict_sentence, warnings_of
from station.results.parameters_by_name import (
    Parameter,
    ParameterShift,
    applied,
    largest,
    parameters,
    shifts,
    shown,
    shown_sigma,
    title_of,
)
from station.results.report.result_tables import LIMIT_SIGMAS, normalised
from station.results.verdict import JudgedLimit, LimitVerdict, judged_in_words
from station.stream.recorder.accepted_step_writer import step_of

if TYPE_CHECKING:
    from procedures.uncertainty.budget import ParameterBudget
    from station.results.campaign_results import CampaignResults

NOTABLE_SIGMAS = 3.0


def verdict_view(results: "CampaignResults", database: Database) -> Verdict:
    """Return a solved campaign's verdict with everything that stands behind it."""
    origin = results.document["provenance"]
    with database.read() as session:
        last = last_calibration(session, origin["model"], origin["serial"], str(results.folder.resolve()))
    previous = None if last is None else json.loads(last.document)
    found = parameters(results.document)
    left_out = read_left_out(results.folder)
    moved = {} if previous is None else shifts(applied(found), parameters(previous))
    verdict = Verdict(
        word=results.outcome.word, in_words=results.outcome.in_words, sentence=results.outcome.sentence,
        doubt=results.doubt, status=results.status, status_reason=results.status_reason,
        worst_residual=worst_residual(results.solution.residuals), change=change_in_words(moved, previous),
        diagnosis=verdict_sentence(results.diagnosis), diagnosis_text=diagnosis_text(results.diagnosis),
        rows=verdict_rows(found, results.outcome, moved, results.budgets),
        warnings=tuple(gap_in_words(warning, left_out) for warning in warnings_of(results.document)),
        redo=_to_redo(results), report=str(results.report_file), solution=str(results.solution_file),
    )  # fmt: skip
    return verdict_without_file_names(verdict)


def _to_redo(results: "CampaignResults") -> str:
    """Return the step to record again: one that surely stood turned, else the seat kept farthest off."""
    steps = {table.file: step_of(table) for table in results.tables.steps()}
    named = (steps.get(name) for name in results.solution.turned_off)
    return next((step.name for step in named if step is not None), worst_kept(results.tables))


def worst_residual(residuals: Sequence[StepResidual]) -> str:
    """Say which step's normalised residual is the largest, against the limit of a report."""
    ratios = [
        (abs(float(ratio)), f"{step.name}, {step.triad} {axis}")
        for step in residuals
        for axis, ratio in zip(AXES, normalised(step), strict=True)
        if math.isfinite(ratio)
    ]
    if not ratios:
        return "no residual: the steps determine the parameters exactly"
    worst, where = max(ratios)
    side = "above" if worst > LIMIT_SIGMAS else "within"
    return f"largest normalised residual {worst:.1f}, {side} the limit of {LIMIT_SIGMAS:g} ({where})"


def change_in_words(moved: Mapping[str, ParameterShift], previous: Mapping[str, Any] | None) -> str:
    """Say what changed most since the last stored calibration."""
    if previous is None:
        return "this is the first calibration of this unit"
    day = str(previous["accepted_utc"])[:10]
    if (most := largest(moved)) is None:
        return f"the calibration of {day} has no parameter to compare with"
    count = sum(abs(one.sigmas) > NOTABLE_SIGMAS for one in moved.values()) or "none"
    return (
        f"since the calibration of {day}, {count} of {len(moved)} parameters changed by more than "
        f"{NOTABLE_SIGMAS:g} u; largest change: {most.parameter.title}, {most}"
    )


def verdict_rows(
    found: Mapping[str, Parameter],
    outcome: LimitVerdict,
    moved: Mapping[str, ParameterShift],
    budgets: Sequence["ParameterBudget"] = (),
) -> tuple[VerdictRow, ...]:
    """Return the table: what a calibration applies, then what else is limited."""
    judged, budget = {one.limit.parameter: one for one in outcome.judged}, {one.name: one for one in budgets}
    names = dict.fromkeys((*applied(found), *judged))
    return tuple(_row(n, found.get(n), judged.get(n), moved.get(n), budget.get(n)) for n in names)


def _row(
    name: str, found: Parameter | None, judged: JudgedLimit | None, moved: ParameterShift | None,
    budget: "ParameterBudget | None",
) -> VerdictRow:  # fmt: skip
    """Return a line; its sigma is the budget's, which a guarded limit is narrowed by, if there is one."""
    value, unit = ("not measured", "") if found is None else shown(found)
    combined = found if found is None or budget is None else replace(found, std=budget.std)
    expanded = None if found is None or budget is None else replace(found, std=budget.expanded)
    return VerdictRow(
        name=title_of(name), value=value, unit=unit, change="" if moved is None else str(moved),
        sigma="" if combined is None else shown_sigma(combined),
        expanded="" if expanded is None else shown_sigma(expanded),
        limit="" if judged is None else judged_in_words(judged), verdict="" if judged is None else judged.word,
    )  # fmt: skip
