"""``station solve``: recorded campaigns to a calibration."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import Effects, argument, option


def solve(
    campaigns: Annotated[list[Path], argument("CAMPAIGN", "Folders of campaign/1.")],
    effects: Effects = None,
    no_moves: Annotated[bool, option("--no-moves", "", "Do not read the recordings of [[move]].")] = False,
    json: Annotated[Path | None, option("--json", "OUT", "Write solution/1 here instead of a summary.")] = None,
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
    from station.files.campaign_folder.campaign_effects import with_effects
    from station.files.campaign_folder.campaign_reading import read_for_solve
    from station.results.solution_json import solution_document
    from station.results.solution_text import solution_text

    loaded = with_effects(read_for_solve(campaigns, moves=not no_moves), effects or [])
    # scipy and kernels: not before the data are right
    from station.results.solve_with_effects import solved

    document = solution_document(*solved(loaded), to_keep=json is not None)
    if json is None:
        typer.echo(solution_text(document))
    else:
        write_json(json, document)
