"""From a recorded campaign to what is handed out: solution, report and, once it is stored, calibration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fixtures_db.campaigns import day_of, known_campaign, last_accepted, references, set_state, why_measured
from fixtures_db.database import Database
from fixtures_db.errors import AlreadyStored
from fixtures_db.imu_models import limits_of
from fixtures_db.journal import journal_head
from fixtures_db.stored_calibrations import CalibrationFacts, accept_calibration, calibration
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.positions import FACES
from station.errors import Altered
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.files.campaign_folder.plan_file import read_note
from station.files.campaign_setup import Setup
from station.results.contradictory_dwells import contradiction_of, kept_tilt_warning
from station.results.measurement_circumstances import circumstances, diagnosis_kept, judged_values
from station.results.verdict import LimitVerdict, judge

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from procedures.uncertainty.budget import ParameterBudget
    from station.results.report.report import CalibrationReport


@dataclass(frozen=True, slots=True, eq=False)
class CampaignResults:
    """A solved campaign: its verdict, and where its results are.

    ``status`` is ``measured`` where cube or slab or a certificate of theirs lacked, or one had expired, when the
    campaign was recorded; ``status_reason`` says which. ``calibration_file`` is there once `store` was called.
    ``document`` is the `solution/1`, ``diagnosis`` the `diagnosis/2`, ``effects`` what the calibration carries of
    it. ``doubt`` says why the calibration is not to be relied on, whatever the limits say; empty if nothing speaks
    against it.
    """

    folder: Path
    solution: Solution
    document: Mapping[str, Any]
    outcome: LimitVerdict
    doubt: str
    status: Literal["calibrated", "measured"]
    status_reason: str
    report: "CalibrationReport"
    budgets: Sequence["ParameterBudget"]
    solution_file: Path
    calibration_file: Path
    report_file: Path
    campaign: Campaign
    tables: CampaignTable
    diagnosis: dict[str, Any]
    effects: tuple[Mapping[str, Any], ...]


def make_results(
    folder: Path, database: Database, into: Path | None = None, *, truth: Mapping[str, float] | None = None
) -> CampaignResults:
    """Solve and diagnose a recorded campaign; write the results to ``into``, else to its folder.

    Nothing is stored. ``truth`` is a simulated unit's, keyed as `Solution.names`.
    """
    loaded = read_for_solve([folder])[0]
    from station.files.atomic_file import write_json
    from station.results.diagnosis.diagnosis_wording import left_in_words
    from station.results.diagnosis.model_refinement import (
        NAME as DIAGNOSIS,  # scipy and kernels: not before the data are right
    )
    from station.results.diagnosis.model_refinement import refine_model
    from station.results.report.report import calibration_report, reported_diagnosis, write_report
    from station.results.result_formats import document_of
    from station.results.solution_json import solution_document

    into = folder if into is None else into
    closed = refine_model([loaded])
    solved = solution_document(closed.solution, [loaded], closed.effects)
    document = document_of(solved)
    with database.read() as session:
        limits = limits_of(session, loaded.tables.imu.model)
        reasons = _why_measured(session, str(folder.resolve()))
    budgets = closed.budgets()
    outcome = judge(document, limits, {one.name: one.std for one in budgets})
    if left := left_in_words(closed.document, budgets):
        outcome = replace(outcome, reason=f"{outcome.reason}. Note: {left}")
    is_certified = len(loaded.campaign.fixture.faces) == len(FACES)
    doubt = kept_tilt_warning(loaded.tables) or contradiction_of(closed.document, is_certified=is_certified)
    if doubt:
        outcome = replace(outcome, reason=f"{doubt}. {outcome.reason[:1].upper()}{outcome.reason[1:]}")
    status_reason = "; ".join(reasons)
    status: Literal["calibrated", "measured"] = "measured" if reasons else "calibrated"
    report = calibration_report(
        closed.solution, [loaded.campaign], solved, budgets, verdict=outcome, truth=truth,
        bench={"Status": f"{status}: {status_reason}" if reasons else status},
        diagnosis=reported_diagnosis(closed, outcome, doubt),
    )  # fmt: skip
    results = CampaignResults(
        folder, closed.solution, document, outcome, doubt, status, status_reason, report, budgets,
        into / "solution.json", into / "calibration.json", into / "report.html",
        loaded.campaign, loaded.tables, closed.document, closed.effects,
    )  # fmt: skip
    write_json(results.solution_file, document)
    write_json(into / DIAGNOSIS, closed.document)
    write_report(results.report_file, report)
    return results


def _why_measured(session: "Session", folder: str) -> list[str]:
    row = known_campaign(session, folder)
    on = datetime.now(UTC) if row is None else last_accepted(row)
    return why_measured(references(session, folder), day_of(on))


def store(results: CampaignResults, database: Database) -> str:
    """Append the calibration to the database, the operator's act; return its hash and mark the campaign accepted.

    It is written out, read back and compared, and the report then names its hash.

    Raise `AlreadyStored` if the same campaign's calibration with the same numbers is there; its file is written
    all the same; `NotInDatabase` if the database does not know the campaign.
    """
    key = str(results.folder.resolve())
    try:
        with database.write() as session:
            row = accept_calibration(session, results.solution, _facts(results, session), campaign_folder=key)
            set_state(session, key, "accepted")
            session.flush()
            code = journal_head(session).code
    except AlreadyStored as error:  # a kill may have come between the row and the files
        with database.read() as session:
            stored, code = calibration(session, error.sha256), journal_head(session).code
        _write_html(results, stored.document, stored.sha256, code)
        raise
    _write_html(results, row.document, row.sha256, code)
    return row.sha256


def _write_html(results: CampaignResults, text: str, sha256: str, journal: str) -> None:
    from station.results.report.report import write_report

    path = results.calibration_file
    replace_file(path, text.encode())
    if path.read_bytes() != text.encode():
        raise Altered(path, "other bytes than were written", sha256)
    write_report(results.report_file, replace(results.report, calibration_sha256=sha256, journal=journal))


def _facts(results: CampaignResults, session: "Session") -> CalibrationFacts:
    from station.results.diagnosis.model_refinement import budget_document
    from station.results.report.report import temperature_range

    origin, now = results.document["provenance"], datetime.now(UTC)
    setup = read_note(results.folder, Setup)
    key, measured = str(results.folder.resolve()), results.campaign
    return CalibrationFacts(
        model=origin["model"],
        serial=origin["serial"],
        software=origin["software"],
        inputs=origin["files"],
        accepted_utc=now,
        valid_from=now,
        temperature_range_c=temperature_range([measured]),
        status=results.status,
        status_reason=results.status_reason,
        operator="" if setup is None else setup.operator,
        verdict=results.outcome.word,
        limits=tuple(one.limit for one in results.outcome.judged),
        uncertainty=budget_document(results.budgets),
        judged=judged_values(results.outcome.judged),
        residual=results.document.get("residual", {}),
        effects=results.effects,
        diagnosis=diagnosis_kept(results.diagnosis),
        **circumstances(session, key, measured, results.tables, results.document),
    )
