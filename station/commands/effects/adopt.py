"""``station effects adopt``: a finding of a diagnosis as a file."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument, option


def adopt(
    diagnosis: Annotated[Path, argument("DIAGNOSIS.json", "A diagnosis/2.")],
    out: Annotated[Path, option("--out", "FILE", "Where to write the effect/1.")],
    finding: Annotated[
        str | None, option("--finding", "N|NAME", "Its number in the diagnosis, or its name; else the only one.")
    ] = None,
    db: Database = None,
) -> None:
    """Write an error term of a diagnosis, found or declared, as an effect/1 that names its origin.

    It must have a term of its own: an error term of the catalogue needs no file. `station effects add` puts the
    file in force. A term that a search proposed stays proposed until you adopt it from the diagnosis, with
    --effects, of other campaigns that show it and whose residuals are then consistent with noise: then it is
    confirmed.

    Exit code 3 if the diagnosis has no such error term, or was changed.

    Example: station effects adopt diagnosis.json --out dead_zone.toml
    """
    from station.results.effect_adopted import adopted
    from station.results.effect_confirmed import confidence_text

    effect, why = adopted(diagnosis, finding, out)
    typer.echo(f"{out}: {effect.name}, effect/1, sha256 {effect.sha256}")
    if said := confidence_text(effect, why):
        typer.echo(said)
