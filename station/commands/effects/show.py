"""``station effects show``: what an effect is, of the catalogue or of a file."""

from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument


def show(
    name: Annotated[str, argument("NAME", "An effect such as gyroscope.magnetic, or a file of effect/1.")],
    db: Database = None,
) -> None:
    """Show an effect: equation, unit, plausible size, source; of a file also its inputs, hash and origin.

    Exit code 3 if there is no such effect, or the file is no effect/1: the line and the place are named.

    Example: station effects show dead_zone.toml
    """
    from station.results.effects_text import effect_text

    typer.echo(effect_text(name))
