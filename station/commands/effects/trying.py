"""``station effects try``: whether campaigns show an effect."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument


def try_(
    file: Annotated[Path, argument("FILE", "An effect/1.")],
    campaigns: Annotated[list[Path], argument("CAMPAIGN...", "Folders of campaign/1 of one unit.")],
    db: Database = None,
) -> None:
    """Diagnose campaigns with a candidate error term added to the catalogue, and report whether they show it.

    It is tested like every error term: it must be significant after correction for all terms tried, predict
    held-out data, and not depend on a single position. Indistinguishable alternatives are listed.

    Exit code 0 for every answer, 3 if the file is no effect/1 or a folder breaks a rule, 5 if neither triad can be
    solved.

    Example: station effects try dead_zone.toml campaigns/S123
    """
    from station.files.campaign_folder.campaign_reading import read_for_solve
    from station.files.effect_file import read_effect
    from station.results.effect_tried import tried_text

    effect = read_effect(file)
    typer.echo(tried_text(effect, read_for_solve(campaigns)))
