"""``station effects``: define, try and use error terms of your own."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import OfModel, OfSerial, argument, flag, option, reading
from station.commands.command_table import Command

COMMANDS = (
    Command("list", "List the user-defined error terms in force.", __name__),
    Command("show", "Show an error term of the catalogue or of a file.", __name__),
    Command("add", "Put an error term in force for a model or a unit.", __name__),
    Command("try", "Test whether campaigns show an error term.", __name__),
    Command("adopt", "Write an error term of a diagnosis as a file.", __name__),
    Command("withdraw", "Take an error term out of force.", __name__),
)


def list_(
    catalogue: Annotated[bool, flag("--catalogue", "Also list the catalogue.")] = False, db: Database = None
) -> None:
    """List the user-defined error terms in force, with model or unit and hash.

    Exit code 1 if the database content differs from what was stored: found and expected hash are printed.

    Example: station effects list --catalogue
    """
    from fixtures_db.imu_models import all_in_force, owner
    from procedures.effects import EFFECTS
    from station.files.effect_file import check_stored
    from station.text import table_lines

    with reading(db) as session:
        rows = [(one.name, owner(one.model, one.serial), one.effect_sha256[:12]) for one in all_in_force(session)]
        rows += [(effect.name, "catalogue", "") for effect in EFFECTS] if catalogue else []
        lines = table_lines(rows, "<<<", ("effect", "of", "sha256"))
        typer.echo("\n".join(lines) if rows else "no user-defined error term is in force")
        check_stored(session)


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
    from fixtures_db.imu_models import all_in_force, owner
    from procedures.effects import EFFECTS
    from station.files.effect_file import check_stored, read_effect, stored_effect
    from station.results.user_defined_effects import effect_text, file_text

    if any(effect.name == name for effect in EFFECTS):
        typer.echo(effect_text(name))
        return
    file = read_effect(Path(name)) if Path(name).exists() else None
    if file is not None:
        typer.echo(effect_text(name))
    with reading(db) as session:
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
    from fixtures_db.imu_models import add_effect, owner
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
    from station.results.user_defined_effects import tried_text

    effect = read_effect(file)
    typer.echo(tried_text(effect, read_for_solve(campaigns)))


def adopt(
    diagnosis: Annotated[Path, argument("DIAGNOSIS.json", "A diagnosis/2.")],
    out: Annotated[Path, option("FILE", "Where to write the effect/1.")],
    finding: Annotated[
        str | None, option("N|NAME", "Its number in the diagnosis, or its name; else the only one.")
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
    from station.results.user_defined_effects import adopted, confidence_text

    effect, why = adopted(diagnosis, finding, out)
    typer.echo(f"{out}: {effect.name}, effect/1, sha256 {effect.sha256}")
    if text := confidence_text(effect, why):
        typer.echo(text)


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
    from fixtures_db.imu_models import owner, withdraw_effect

    with open_db(db) as database, database.write() as session:
        withdraw_effect(session, name, model, serial)
    typer.echo(f"{name}: withdrawn from {owner(model, serial)}")
