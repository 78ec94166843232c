"""From a recorded campaign to what is handed out: solution, calibration and report."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from fixtures_db.calibration import CalibrationFacts
from fixtures_db.database import Database
from fixtures_db.history import accept_calibration
from procedures.campaign import Campaign
from procedures.solution import Solution
from station.campaign_folder import LoadedCampaign, read_for_solve
from station.campaign_folder.atomic import replace_file
from station.errors import Altered


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """A solved campaign and where its results are; ``sha256`` is the stored calibration's."""

    solution: Solution
    document: Mapping[str, Any]
    sha256: str
    solution_file: Path
    calibration_file: Path
    report_file: Path


def make_results(
    folder: Path,
    database: Database,
    into: Path | None = None,
    *,
    truth: Mapping[str, float] | None = None,
    is_expired: bool = False,
) -> Results:
    """Solve a recorded campaign, store its calibration, and write all three files to ``into``, else to its folder.

    ``truth`` is a simulated unit's, keyed as `Solution.names`. ``is_expired``: the cube's certificate has run
    out, so that the calibration counts as measured only.
    """
    loaded = read_for_solve([folder])[0]
    from procedures.calibration import solve  # scipy and kernels: not before the data are right
    from station.report.context import report_context
    from station.report.writing import write_report
    from station.solution_json import solution_document, write_solution

    into = folder if into is None else into
    solution = solve([loaded.campaign])
    document = solution_document(solution, [loaded])
    results = Results(
        solution, document, _store(folder, database, loaded, solution, document, into, is_expired),
        into / "solution.json", into / "calibration.json", into / "report.html",
    )  # fmt: skip
    write_solution(results.solution_file, document)
    context = report_context(solution, [loaded.campaign], document)
    context = replace(context, truth=truth or {}, calibration_sha256=results.sha256)
    write_report(results.report_file, context)
    return results


def _store(
    folder: Path,
    database: Database,
    loaded: LoadedCampaign,
    solution: Solution,
    document: Mapping[str, Any],
    into: Path,
    is_expired: bool,
) -> str:
    """Append the calibration to the database and write it out; what was written is read back and compared."""
    origin, now = document["provenance"], datetime.now(UTC)
    facts = CalibrationFacts(
        model=origin["model"],
        serial=origin["serial"],
        software=origin["software"],
        inputs=origin["files"],
        accepted_utc=now,
        valid_from=now,
        temperature_range_c=_temperatures(loaded.campaign),
        status="measured" if is_expired else "calibrated",
    )
    with database.write() as session:
        row = accept_calibration(session, solution, facts, campaign_folder=str(folder.resolve()))
        text, sha256 = row.document, row.sha256
    path = into / "calibration.json"
    replace_file(path, text.encode())
    if path.read_bytes() != text.encode():
        raise Altered(path, "other bytes than were written", sha256)
    return sha256


def _temperatures(campaign: Campaign) -> tuple[float, float] | None:
    series = [*(dwell.series for dwell in campaign.dwells), *(turn.series for turn in campaign.turns)]
    values = np.concatenate([each.temperature for each in series])
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if len(values) else None
