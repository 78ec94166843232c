"""``station verify``: what was recorded and stored against what is there."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database

if TYPE_CHECKING:
    from fixtures_db.chain import ChainFault
    from fixtures_db.database import Database as OpenDatabase


def verify(
    folder: Annotated[
        Path | None, typer.Argument(metavar="[FOLDER]", help="A recorded campaign's folder; else the database.")
    ] = None,
    db: Database = None,
) -> None:
    """Look for anything that was altered since it was accepted.

    With a folder: hash every recorded file again and compare with SHA256SUMS, written when it was accepted, and
    with the database's rows if it knows the campaign. Without: check the database's chains of calibrations and of
    face certificates, and the accepted steps of every campaign.

    Exit code 1 names the first that differs or is missing; 3 if a folder has no hashes to compare with.

    Example: station verify campaigns/2026-05-11
    """
    from fixtures_db.database import default_path, open_db

    if folder is None:
        with open_db(db) as database:
            typer.echo(_database(database))
        return
    from station.campaign_folder.manifest import verify_folder

    names = verify_folder(folder)
    typer.echo(f"{folder}: {len(names)} files are as recorded")
    where = str(default_path()) if db is None else db
    if "://" in where or Path(where).exists():  # a check makes no database
        with open_db(where) as database:
            typer.echo(_rows(database, folder))


def _database(database: "OpenDatabase") -> str:
    from fixtures_db.history import head
    from fixtures_db.verification import alterations

    with database.read() as session:
        _refuse(alterations(session))
        return f"{database.url}: as stored; newest calibration {head(session)}"


def _rows(database: "OpenDatabase", folder: Path) -> str:
    """Compare the hashes of a folder, whose files agree with them, with the rows of its accepted steps."""
    from fixtures_db.campaigns import known_campaign, verify_steps
    from station.campaign_folder import read_hashes
    from station.errors import Altered

    key, hashes = str(folder.resolve()), read_hashes(folder)
    with database.read() as session:
        if (row := known_campaign(session, key)) is None:
            return f"{database.url} does not know this campaign: compared with SHA256SUMS alone"
        for step in row.steps:
            found = hashes.get(step.file, ("none", 0))[0]
            if found != step.sha256:
                raise Altered(folder / step.file, f"sha256 {found}", f"{step.sha256} in the database")
        _refuse(verify_steps(session, key))
        return f"{database.url}: {len(row.steps)} accepted steps are as stored"


def _refuse(faults: Sequence["ChainFault"]) -> None:
    from station.errors import Altered

    if faults:
        first = faults[0]
        raise Altered(first.row, first.found, first.expected, "restore the database from a copy")
