"""The effects in force of a unit, copied into a campaign's folder as it begins."""

from pathlib import Path

from fixtures_db.database import Database
from fixtures_db.user_effects import effects_in_force
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import EffectsTable
from station.files.effect_file import check_stored, stored_effect
from station.files.sha256sums import append_hash


def copy_effects(database: Database, model: str, serial: str, folder: Path) -> EffectsTable | None:
    """Return what ``campaign.toml`` is to list, its files written and hashed; None where nothing is in force.

    Raises
    ------
    DataRefused
        If what the database holds is no `effect/1`.
    Altered
        If an event of effects, of whatever unit, is not what was stored: what is in force is then not known.
    CannotWrite
        If the folder cannot be written.
    """
    with database.read() as session:
        check_stored(session)
        rows = effects_in_force(session, model, serial)
    names = [f"effect_{row.name.replace('.', '_')}.toml" for row in rows]
    for row, name in zip(rows, names, strict=True):
        stored_effect(row.definition, row.effect_sha256, row.name)
        replace_file(folder / name, row.definition.encode())
        append_hash(folder, name, row.effect_sha256)
    return EffectsTable(files=names, sha256=[row.effect_sha256 for row in rows]) if rows else None
