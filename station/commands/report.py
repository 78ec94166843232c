"""``station report``: recorded campaigns to one HTML file to read, print and keep."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument, option


def report(
    campaigns: Annotated[list[Path], argument("CAMPAIGN", "Folders of campaign/1.")],
    out: Annotated[
        Path | None, option("--out", "FILE.html", "Where to write; else report.html in the folder.")
    ] = None,
    db: Database = None,
) -> None:
    """Solve and diagnose recorded campaigns; write the calibration report, one self-contained HTML file for A4.

    It lists every parameter with standard uncertainty u and unit (count/(g s), count/deg, ug, deg/h, arcsec), its
    uncertainty budget (expanded uncertainty U, coverage factor k, largest contributions), the residual of every
    step against its limit, the Allan deviation of the longest dwell, conditions, warnings and the hashes of the
    inputs.

    Exit code 3 if a folder breaks a rule of campaign/1, 5 if neither triad can be solved.

    Example: station report campaigns/2026-05-11 --out report.html
    """
    from station.files.campaign_folder.campaign_reading import read_for_solve
    from station.results.solution_json import solution_document

    loaded = read_for_solve(campaigns)
    # scipy and kernels: not before the data are right
    from station.results.diagnosis.closed_loop import close_loop
    from station.results.diagnosis.diagnosis_html import section_html
    from station.results.diagnosis.diagnosis_wording import verdict_sentence
    from station.results.report.report import report_context, write_report
    from station.results.verdict import what_to_do

    closed = close_loop(loaded)
    document = solution_document(closed.solution, loaded, closed.effects)
    origin = document["provenance"]
    target = campaigns[0] / "report.html" if out is None else out
    context = report_context(closed.solution, closed.fits.campaigns, document, closed.budgets())
    context = replace(
        context,
        diagnosis=section_html(closed.document, closed.diagnosis),
        cause=verdict_sentence(closed.document),
        advice=what_to_do("NOT_MEASURED", closed.document["next_measurement"], has_limits=False),
    )
    write_report(target, context)
    typer.echo(f"{target}: calibration report of {origin['model']} {origin['serial']}")
