"""``station solve``, ``resolve`` and ``report``: campaigns solved, solved again, reported."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from station.commands import Database
from station.commands._options import Effects, argument, flag, option, write_result

if TYPE_CHECKING:
    from procedures.calibration.solution_values import Solution
    from station.files.campaign_folder.loaded_campaign import LoadedCampaign


def solve(
    campaigns: Annotated[list[Path], argument("CAMPAIGN", "Folders of campaign/1.")],
    effects: Effects = None,
    no_moves: Annotated[bool, flag("--no-moves", "Do not read the recordings of [[move]].")] = False,
    json: Annotated[Path | None, option("OUT", "Write solution/1 here instead of a summary.")] = None,
    db: Database = None,
) -> None:
    """Solve recorded campaigns for scale factor, misalignment and bias of both triads, each with uncertainty.

    Several campaigns of one unit are solved jointly. Scale factors are in count/(g s) and count/deg, biases in g
    and deg/h, tilts in rad (arcsec in the summary). Steps that the solution does not use are checked and listed.

    Error terms that a folder lists under [effects], or that --effects names, are in the model; no others.

    Exit code 3 if a folder breaks a rule of campaign/1, 5 if neither triad can be solved.

    Example: station solve campaigns/2026-05-11 --json solution.json
    """
    from station.files.atomic_file import write_json
    from station.files.campaign_folder.campaign_reading import read_for_solve
    from station.files.campaign_folder.loaded_campaign import with_effects
    from station.results.result_formats import document_of
    from station.results.solution_json import solution_document
    from station.results.solution_text import solution_text

    loaded = with_effects(read_for_solve(campaigns, moves=not no_moves), effects or [])
    document = solution_document(*_solved(loaded), to_keep=json is not None)
    if json is None:
        typer.echo(solution_text(document))
    else:
        write_json(json, document_of(document))


def _solved(
    campaigns: Sequence["LoadedCampaign"],
) -> tuple["Solution", Sequence["LoadedCampaign"], list[dict[str, Any]]]:
    """Return solution, campaigns and effects, as `station.results.solution_json.solution_document` takes them."""
    from procedures.calibration.joint_calibration import solve  # scipy and kernels: not before the data are right
    from station.files.campaign_folder.loaded_campaign import effects_of

    files = effects_of(campaigns)
    if not files:
        return solve([one.campaign for one in campaigns]), campaigns, []
    from procedures.diagnosis.declared_effects import solve_declared  # the loop, heavy: only where it is needed
    from station.results.diagnosis.diagnosis_json import effect_entries
    from station.results.diagnosis.magnetic_field import with_magnetic_field

    campaigns = [with_magnetic_field(one) for one in campaigns]
    found = solve_declared([one.campaign for one in campaigns], [file.term for file in files])
    return found.solution, campaigns, effect_entries(found.effects, files)


def resolve(
    campaigns: Annotated[list[Path] | None, argument("[CAMPAIGN]...", "Folders of campaign/1.")] = None,
    every: Annotated[bool, flag("--all", "Every complete campaign of the database.")] = False,
    scheduler: Annotated[
        str | None, option("ADDRESS", "A Dask scheduler, tcp://HOST:8786; else this machine.")
    ] = None,
    workers: Annotated[
        int | None, option("", "Processes here; else as many as there are cores.", min=1, max=1024)
    ] = None,
    out: Annotated[Path | None, option("FOLDER", "Keep solutions here; else in the user's cache folder.")] = None,
    json: Annotated[Path | None, option("OUT", "Write resolve/1 here instead of a summary.")] = None,
    db: Database = None,
) -> None:
    """Solve campaigns again with today's code and report what changed; stored results stay unchanged.

    Each campaign is solved and diagnosed by itself and compared with its newest stored calibration, else with its
    solution.json: changes in units of the uncertainty stated before (same counts), verdicts against today's
    limits, new findings of the diagnosis, new warnings, refusals with reason, and files changed since they were
    recorded. A new calibration is stored only when the operator confirms it.

    An interrupted run continues where it stopped; a second run computes only campaigns with other files or other
    code. With --scheduler every worker needs this station and the folders under the same path. One worker needs no
    Dask; more need the extra `cluster`.

    Exit code 1 if a verdict changed to FAIL or a recording was changed, 2 if there is no cluster, 4 if it was lost
    during the run. A refused campaign is named and does not stop the others; if none is solved, the exit code is
    that of the first refusal.

    Example: station resolve --all --workers 2 --json resolve.json
    """
    import sys

    from platformdirs import user_cache_path

    from fixtures_db.campaigns import complete_campaigns
    from fixtures_db.database import open_db
    from station.errors import DataRefused
    from station.results.resolve.parallel_map import open_engine

    if bool(campaigns) == every:
        raise typer.BadParameter("found both campaigns and --all, or neither; expected one of them")
    if scheduler is not None and workers is not None:
        raise typer.BadParameter("--workers is of this machine; expected it without --scheduler")
    keep = user_cache_path("fog-station") / "resolve" if out is None else out
    with open_db(db) as database:
        folders = [str(folder.resolve()) for folder in campaigns or ()]
        if every:
            with database.read() as session:
                folders = [row.folder for row in complete_campaigns(session)]
        if not folders:
            raise DataRefused(
                database.url, None, "no complete campaign", "one at least", "check --db or STATION_DB"
            )
        with open_engine(workers, scheduler) as engine:
            from station.results.resolve.fleet import resolve_fleet

            document = resolve_fleet(list(dict.fromkeys(folders)), database, engine, keep, sys.stderr)
    from station.results.resolve.fleet import exit_code, resolve_text

    write_result(document, resolve_text(document), json, "what changed, resolve/1")
    raise typer.Exit(exit_code(document))


def report(
    campaigns: Annotated[list[Path], argument("CAMPAIGN", "Folders of campaign/1.")],
    out: Annotated[Path | None, option("FILE.html", "Where to write; else report.html in the folder.")] = None,
    db: Database = None,
) -> None:
    """Solve and diagnose recorded campaigns; write the calibration report, one self-contained HTML file for A4.

    It lists every parameter with standard uncertainty u and unit (count/(g s), count/deg, ug, deg/h, arcsec), its
    uncertainty budget (expanded uncertainty U, coverage factor k, largest contributions), the residual of every
    step against its limit, the noise of every channel, conditions, warnings and the hashes of the inputs.

    Exit code 3 if a folder breaks a rule of campaign/1, 5 if neither triad can be solved.

    Example: station report campaigns/2026-05-11 --out report.html
    """
    from station.files.campaign_folder.campaign_reading import read_for_solve
    from station.results.solution_json import solution_document

    loaded = read_for_solve(campaigns)
    # scipy and kernels: not before the data are right
    from station.results.diagnosis.model_refinement import refine_model
    from station.results.report.report import NO_LIMITS, calibration_report, reported_diagnosis, write_report

    refined = refine_model(loaded)
    document = solution_document(refined.solution, loaded, refined.effects)
    origin = document.provenance
    target = campaigns[0] / "report.html" if out is None else out
    found, budgets = reported_diagnosis(refined, NO_LIMITS), refined.budgets()
    write_report(
        target, calibration_report(refined.solution, refined.fits.campaigns, document, budgets, diagnosis=found)
    )
    typer.echo(f"{target}: calibration report of {origin.model} {origin.serial}")
