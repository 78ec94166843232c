"""``station resolve``: recordings solved again with today's code, and what that changes."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument, hand_out, option


def resolve(
    campaigns: Annotated[list[Path] | None, argument("[CAMPAIGN]...", "Folders of campaign/1.")] = None,
    every: Annotated[bool, option("--all", "", "Every complete campaign of the database.")] = False,
    scheduler: Annotated[
        str | None, option("", "ADDRESS", "A Dask scheduler, tcp://HOST:8786; else this machine.")
    ] = None,
    workers: Annotated[
        int | None, option("", "", "Processes here; else as many as there are cores.", min=1, max=1024)
    ] = None,
    out: Annotated[
        Path | None, option("", "FOLDER", "Keep solutions here; else in the user's cache folder.")
    ] = None,
    json: Annotated[Path | None, option("--json", "OUT", "Write resolve/1 here instead of a summary.")] = None,
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
    from station.results.cluster.engine import open_engine

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
    from station.results.resolve.resolve_text import exit_code, resolve_text

    hand_out(document, resolve_text(document), json, "what changed, resolve/1")
    raise typer.Exit(exit_code(document))
