"""Databases that nobody edited: migrated from each version, exported, moved, compacted, worked with."""

import random
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import select

from fixtures_db import stored_calibrations
from fixtures_db.campaigns import accept_step, in_state, remove_campaign, set_state
from fixtures_db.database import Database, open_db
from fixtures_db.fixture_measurements import dump, restore
from fixtures_db.hash_chain import ChainFault
from fixtures_db.imu_models import add_effect, all_in_force, set_limits, withdraw_effect
from fixtures_db.journal import columns_there, journalled_tables
from fixtures_db.migrations import KNOWN
from fixtures_db.stored_calibrations import accept_calibration
from fixtures_db.verification import alterations, take_anchor
from tests.empty_database import of_schema
from tests.fixtures_db.factory import LATER, facts, solution
from tests.fixtures_db.filled_database import WIDE, fill

XML_SINCE, JOURNAL_SINCE = "0009", "0011"
EXAMPLE, EXAMPLE_SINCE = "P1", "0002"


def of_version(version: str, home: Path) -> Path:
    """Return a filled database as a station of a schema version left it."""
    file, source = home / f"{version}.db", home / f"{version}_source.db"
    with pytest.MonkeyPatch.context() as patch, open_db(source) as database, database.write() as session:
        if version < JOURNAL_SINCE:  # a calibration of then names no entry of a journal
            patch.setattr(stored_calibrations, "grounds_now", lambda *_: {})
        fill(session, digital=version >= XML_SINCE)
    if version == KNOWN[-1]:
        return source
    made = of_schema(version, file)
    with open_db(source) as database, database.engine.connect() as filled, made as connection:
        connection.exec_driver_sql("DELETE FROM tolerance_items")
        connection.exec_driver_sql("DELETE FROM cubes")
        for table in journalled_tables():
            if columns := columns_there(connection, table):
                rows = [dict(row) for row in filled.execute(select(*columns)).mappings()]
                if version < EXAMPLE_SINCE:
                    rows = [row for row in rows if EXAMPLE not in {row["id"], row.get("cube_id")}]
                if rows:
                    connection.execute(table.insert().values(dict.fromkeys(columns)), rows)
    return file


def worked_with(database: Database, chance: random.Random) -> None:
    """Do some of what a station does in a week."""
    with database.write() as session:
        recording = in_state(session, "recording")
        for bias in range(chance.randrange(3)):
            accept_calibration(session, solution(1e-3 + bias * 1e-5), facts("S2"))
        if recording and chance.random() < 0.5:
            accept_step(session, recording[0].folder, name="dwell_01", file=f"again{chance.random()}",
                        sha256="12" * 32, accepted_utc=LATER)  # fmt: skip
        if recording and chance.random() < 0.3:
            remove_campaign(session, recording[0].folder)
        elif recording:
            set_state(session, recording[0].folder, chance.choice(("recording", "recorded")))
        if chance.random() < 0.5:
            set_limits(session, chance.choice(("FOG-3", "FOG-7")), WIDE[: chance.randrange(3)])
        if rows := all_in_force(session):
            withdraw_effect(session, rows[0].name, rows[0].model, rows[0].serial)
        else:
            add_effect(session, "pull", f"title = '{chance.random()}'", "FOG-3", None)


def moved(file: Path, to: Path, how: str) -> Path:
    """Return a database that was compacted, moved, copied or restored."""
    if how in {"stays", "moved"}:
        return file if how == "stays" else Path(shutil.move(file, to))
    if how == "export":
        with open_db(file) as database, database.read() as session:
            rows = dump(session)
        with open_db(to) as database, database.write() as session:
            restore(session, rows)
        return to
    with closing(sqlite3.connect(file)) as connection, closing(sqlite3.connect(to)) as copy:
        match how:
            case "VACUUM":
                connection.execute("VACUUM")
            case "VACUUM INTO":
                connection.execute("VACUUM INTO ?", (str(to),))
            case "backup":
                connection.backup(copy)
            case "SQL dump":
                copy.executescript("\n".join(connection.iterdump()))
    return file if how == "VACUUM" else to


WAYS = ("stays", "VACUUM", "VACUUM INTO", "backup", "SQL dump", "moved", "export")


def false_alarms(home: Path, count: int, chance: random.Random) -> list[tuple[str, ChainFault]]:
    """Return what is said of ``count`` honest databases, against their anchors too, by where they come from."""
    versions = {version: of_version(version, home) for version in KNOWN}
    found = list[tuple[str, ChainFault]]()
    for number in range(count):
        version, way = KNOWN[number % len(KNOWN)], WAYS[number // len(KNOWN) % len(WAYS)]
        file = home / f"honest_{number}.db"
        shutil.copy(versions[version], file)
        with open_db(file) as database:
            worked_with(database, chance)
            with database.read() as session:
                anchor = take_anchor(session)
        file = moved(file, home / f"honest_{number}_to.db", way)
        with open_db(file) as database:
            worked_with(database, chance)
            with database.read() as session:
                faults = alterations(session, anchor if way != "export" else None)
        found += [(f"{version} {way}", fault) for fault in faults]
        for each in home.glob(f"honest_{number}*"):
            each.unlink()
    return found
