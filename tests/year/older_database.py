"""The station's database as an older program would have left it."""

import sqlite3
from contextlib import closing
from pathlib import Path

from alembic import command
from sqlalchemy import create_engine

from fixtures_db.database import open_db
from fixtures_db.migrations.upgrade import config

OLDER = "0009"  # what came after it are tables that a campaign does not fill


def older_database(path: Path) -> None:
    """Make an empty database of the older schema."""
    engine = create_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        made = config()
        made.attributes["connection"] = connection
        command.upgrade(made, OLDER)
    engine.dispose()


def take_back(path: Path) -> bool:
    """Put all rows of a database into one of the older schema, at its place, unless a calibration is stored.

    A calibration names the journal's entry after which it was stored, and an older program had no journal.
    """
    open_db(path).close()  # what stood in the log next to it is in it
    with closing(sqlite3.connect(path)) as now:
        if now.execute("SELECT count(*) FROM calibrations").fetchone()[0]:
            return False
    aside = path.with_name("older.db")
    aside.unlink(missing_ok=True)
    older_database(aside)
    with closing(sqlite3.connect(aside)) as older:
        older.execute("PRAGMA foreign_keys = OFF")
        older.execute("ATTACH ? AS newer", (str(path),))
        tables = [row[0] for row in older.execute("SELECT name FROM main.sqlite_master WHERE type = 'table'")]
        for table in sorted(set(tables) - {"alembic_version", "sqlite_sequence"}):
            columns = ", ".join(f'"{row[1]}"' for row in older.execute(f"PRAGMA main.table_info({table})"))
            older.execute(f"INSERT OR IGNORE INTO main.{table} ({columns}) SELECT {columns} FROM newer.{table}")
        older.commit()
    for end in ("", "-wal", "-shm"):
        path.with_name(path.name + end).unlink(missing_ok=True)
    aside.rename(path)
    return True
