"""``station effects add``: an effect of one's own for a model or a unit."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import OfModel, OfSerial, argument


def add(
    file: Annotated[Path, argument("FILE", "An effect/1.")],
    model: OfModel,
    serial: OfSerial = None,
    db: Database = None,
) -> None:
    """Put an error term in force for an IMU model, or with --serial for one unit.

    `station calibrate` then copies it into the folder of every new campaign of that model or unit. It replaces one
    of the same name; nothing is deleted, every event is a link of a hash chain that `station verify` checks.

    Exit code 3 if the file is no effect/1, or the same is in force already.

    Example: station effects add dead_zone.toml --model FOG-3 --serial S107
    """
    from fixtures_db.campaigns import is_known_imu
    from fixtures_db.database import open_db
    from fixtures_db.user_effects import add_effect, owner
    from station.files.effect_file import read_effect

    for name, value in (("--model", model), ("--serial", serial)):
        if value is not None and not value.strip():
            raise typer.BadParameter("found an empty name, expected that of an IMU", param_hint=name)
    effect = read_effect(file)
    with open_db(db) as database, database.write() as session:
        add_effect(session, effect.name, effect.text, model, serial)
        is_known = is_known_imu(session, model, serial)
    typer.echo(f"{effect.name}: in force for {owner(model, serial)}, sha256 {effect.sha256}")
    if not is_known:
        typer.echo(
            f"no unit of model {model} is known yet" if serial is None else f"{model} {serial} is not known yet"
        )
