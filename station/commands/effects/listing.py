"""``station effects list``: the catalogue, and the effects of one's own that are in force."""

from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import option


def list_(
    catalogue: Annotated[bool, option("--catalogue", "", "Also list the catalogue.")] = False,
    db: Database = None,
) -> None:
    """List the user-defined error terms in force, with model or unit and hash.

    Exit code 1 if the database content differs from what was stored: found and expected hash are printed.

    Example: station effects list --catalogue
    """
    from fixtures_db.database import open_db
    from fixtures_db.user_effects import all_in_force, owner
    from procedures.effects import EFFECTS
    from station.files.stored_effects import check_stored
    from station.text.table import table_lines

    with open_db(db) as database, database.read() as session:
        rows = [(one.name, owner(one.model, one.serial), one.effect_sha256[:12]) for one in all_in_force(session)]
    rows += [(effect.name, "catalogue", "") for effect in EFFECTS] if catalogue else []
    lines = table_lines(rows, "<<<", ("effect", "of", "sha256"))
    typer.echo("\n".join(lines) if rows else "no user-defined error term is in force")
    with open_db(db) as database, database.read() as session:
        check_stored(session)
