"""``station effects show``: what an effect is, of the catalogue or of a file."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument


def show(
    name: Annotated[str, argument("NAME", "An error term such as gyroscope.magnetic, or a file of effect/1.")],
    db: Database = None,
) -> None:
    """Show an error term: equation, unit, expected size, source; of a file also its inputs, hash and origin.

    A name is looked up in the catalogue, then among the error terms in force.

    If a file has the name of one in force but another hash, both hashes are printed.

    Exit code 1 if the database content differs from what was stored; 3 if there is no such error term, or the file
    is no effect/1: line and place are named.

    Example: station effects show dead_zone.toml
    """
    from fixtures_db.database import open_db
    from fixtures_db.user_effects import all_in_force, owner
    from procedures.effects import EFFECTS
    from station.files.effect_file import read_effect, stored_effect
    from station.files.stored_effects import check_stored
    from station.results.effects_text import effect_text, file_text

    if any(effect.name == name for effect in EFFECTS):
        typer.echo(effect_text(name))
        return
    file = read_effect(Path(name)) if Path(name).exists() else None
    if file is not None:
        typer.echo(effect_text(name))
    with open_db(db) as database, database.read() as session:
        check_stored(session)
        rows = all_in_force(session)
    if file is not None:
        for row in rows:
            if row.name == file.name and row.effect_sha256 != file.sha256:
                found, expected = f"found sha256 {file.sha256}", f"expected {row.effect_sha256}"
                typer.echo(
                    f"  different from the one in force for {owner(row.model, row.serial)}: {found}, {expected}"
                )
        return
    stored = [row for row in rows if row.name == name]
    for row in stored:
        known = file_text(stored_effect(row.definition, row.effect_sha256, row.name))
        typer.echo(f"{known}\n  in force for {owner(row.model, row.serial)} since {row.recorded_utc:%Y-%m-%d}")
    if not stored:
        effect_text(name, list(dict.fromkeys(row.name for row in rows)))
