"""``station effects withdraw``: an effect of one's own out of force."""

from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import OfModel, OfSerial, argument


def withdraw(
    name: Annotated[str, argument("NAME", "Such as gyroscope.dead_zone.")],
    model: OfModel,
    serial: OfSerial = None,
    db: Database = None,
) -> None:
    """Take an error term out of force: new campaigns are solved without it.

    Nothing is deleted: it stays in the database, and in the folders that contain it.

    Exit code 3 if it is not in force for that model or unit.

    Example: station effects withdraw gyroscope.dead_zone --model FOG-3 --serial S107
    """
    from fixtures_db.database import open_db
    from fixtures_db.user_effects import owner, withdraw_effect

    with open_db(db) as database, database.write() as session:
        withdraw_effect(session, name, model, serial)
    typer.echo(f"{name}: withdrawn from {owner(model, serial)}")
