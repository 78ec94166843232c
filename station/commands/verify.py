"""``station verify``: what was recorded against what is there."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database


def verify(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="A recorded campaign's folder.")],
    db: Database = None,
) -> None:
    """Hash every recorded file of a campaign again and compare with SHA256SUMS, written when it was accepted.

    Exit code 1 names the first file that differs or is missing; 3 if there are no hashes to compare with.

    Example: station verify campaigns/2026-05-11
    """
    from station.campaign_folder.manifest import verify_folder

    names = verify_folder(folder)
    typer.echo(f"{folder}: {len(names)} files are as recorded")
